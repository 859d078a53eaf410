// What a technique's author includes: the fragment as an operation sees it (rop/technique_input.h), the
// concept a technique satisfies (rop/technique_concept.h), and the line that makes it known to the registry.
#pragma once

#include "rop/charged_operation.h"
#include "rop/operation_of.h"
#include "rop/technique_concept.h"
#include "rop/technique_input.h"

#include <memory>

// Ends a technique's file: makes the class known to the registry under the name of its line in registry.def.
// NOLINTBEGIN(bugprone-macro-parentheses): the class is a template argument.
#define ROPSIM_TECHNIQUE(name, Class)                                                                 \
    namespace ropsim::techniques {                                                                    \
    TechniqueInfo name##_info() {                                                                     \
        return Class::kInfo;                                                                          \
    }                                                                                                 \
    std::unique_ptr<FramebufferOperation> make_##name(Parameters& parameters, const Screen& screen) { \
        return std::make_unique<OperationOf<Class>>(parameters, screen);                              \
    }                                                                                                 \
    }
// NOLINTEND(bugprone-macro-parentheses)
