// Files that appear under their final name only when they are complete.
#include "base/atomic_file.h"

#include "base/cleanup_on_signal.h"
#include "base/error.h"

#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace ropsim {

namespace {

std::string reason() {
    return std::strerror(errno);
}

struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
};
using FileHandle = std::unique_ptr<std::FILE, CloseFile>;

}  // namespace

AtomicFile::AtomicFile(std::string path) : path_(std::move(path)) {
    static std::atomic<unsigned> serial{0};
    struct stat status {};
    if (path_.empty()) throw UserError("output file", "the name is empty; give a path");
    // Renaming over a directory fails late; renaming over a device such as /dev/null would replace the
    // device.
    if (::stat(path_.c_str(), &status) == 0 && !S_ISREG(status.st_mode))
        throw UserError(path_, "exists and is not a regular file; choose another name");
    temporary_ = fmt::format("{}.partial-{}-{}", path_, ::getpid(), serial++);
    const int file = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file < 0) {
        const std::string why = reason();
        throw UserError(path_, fmt::format("cannot create a file there ({}); check the directory", why));
    }
    ::close(file);
    remove_on_signal(temporary_);
}

AtomicFile::~AtomicFile() {
    if (committed_) return;
    ::unlink(temporary_.c_str());
    leave_on_signal(temporary_);
}

void AtomicFile::commit() {
    CHECK(!committed_, "{}", path_);
    // Without the flush a crash of the machine could leave the name pointing at an empty file.
    const int file = ::open(temporary_.c_str(), O_RDONLY | O_CLOEXEC);
    const bool flushed = file >= 0 && ::fsync(file) == 0;
    const std::string why = reason();
    if (file >= 0) ::close(file);
    if (!flushed) throw UserError(path_, fmt::format("cannot write ({}); check the disk", why));
    if (::rename(temporary_.c_str(), path_.c_str()) != 0)
        throw UserError(path_, fmt::format("cannot put the finished file in place ({})", reason()));
    committed_ = true;
    leave_on_signal(temporary_);
}

void write_file(const std::string& path, std::string_view content) {
    AtomicFile file(path);
    FileHandle out(std::fopen(file.temporary_path().c_str(), "wb"));
    const bool written = out && std::fwrite(content.data(), 1, content.size(), out.get()) == content.size() &&
                         std::fflush(out.get()) == 0;
    if (!written) throw UserError(path, fmt::format("cannot write ({}); check the disk", reason()));
    out.reset();
    file.commit();
}

std::string read_file(const std::string& path) {
    std::error_code error;
    if (std::filesystem::is_directory(path, error)) throw UserError(path, "is a directory; a file is wanted");
    FileHandle in(std::fopen(path.c_str(), "rb"));
    if (!in) throw UserError(path, fmt::format("cannot open ({})", reason()));
    std::string content;
    std::array<char, 65536> piece;
    while (const std::size_t size = std::fread(piece.data(), 1, piece.size(), in.get()))
        content.append(piece.data(), size);
    if (std::ferror(in.get())) throw UserError(path, fmt::format("cannot read ({})", reason()));
    return content;
}

}  // namespace ropsim
