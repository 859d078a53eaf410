// Fuzzes command lines, an argument a line. Every one is parsed; those of commands that need no OpenGL and little
// work are then run, in a directory with small inputs of each kind. Each ends well, or in one line that the user
// can read.
#include "base/error.h"
#include "cli/command_line.h"
#include "rop/exr_image.h"
#include "rop/reference.h"
#include "tests/fuzz/fuzz_input.h"
#include "traces/generators.h"
