// A directory that goes away again.
#include "base/temporary_directory.h"

#include "base/cleanup_on_signal.h"
#include "base/error.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

namespace ropsim {

namespace fs = std::filesystem;

TemporaryDirectory::TemporaryDirectory() {
    std::error_code failure;
    const fs::path parent = fs::temp_directory_path(failure);
    if (failure) throw UserError("TMPDIR", "is no directory; set it to one");
    std::string name = (parent / "ropsim-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr)
        throw UserError(parent.string(), fmt::format("no directory could be made there: {}; choose another "
                                                     "with TMPDIR",
                                                     std::strerror(errno)));
    path_ = name;
    remove_on_signal(path_);
}

TemporaryDirectory::~TemporaryDirectory() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
    leave_on_signal(path_);
}

}  // namespace ropsim
