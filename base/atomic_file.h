// Files that appear under their final name only when they are complete.
#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace ropsim {

// A temporary path beside `path`; commit() renames it to `path`, otherwise the destructor removes it. Removed
// also when the process is interrupted or crashes if install_cleanup_on_signal() was called.
class AtomicFile {
 public:
    // Throws UserError when the directory does not exist or is not writable.
    explicit AtomicFile(std::string path);
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    const std::string& temporary_path() const { return temporary_; }
    const std::string& path() const { return path_; }
    // Flushes to disk and renames. Throws UserError when the file system refuses.
    void commit();

 private:
    std::string path_;
    std::string temporary_;
    bool committed_ = false;
};

// Writes `content` to `path` atomically. Throws UserError.
void write_file(const std::string& path, std::string_view content);
// Reads a whole file. Throws UserError.
std::string read_file(const std::string& path);

}  // namespace ropsim
