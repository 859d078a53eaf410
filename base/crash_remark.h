// What a user is told when code that is not ours takes the process down.
#pragma once

namespace ropsim {

// While one lives, foreign code (a driver) is at work, and a crash is answered by one line on stderr:
// `remark`, "where: what, and how to mend it", which must outlive this. The inner of two counts. Said by the
// handlers of install_cleanup_on_signal().
class CrashRemark {
 public:
    explicit CrashRemark(const char* remark);
    ~CrashRemark();
    CrashRemark(const CrashRemark&) = delete;
    CrashRemark& operator=(const CrashRemark&) = delete;

    static const char* current();  // null: none; callable in a signal handler
    static void forget();          // the crash that comes is ours

 private:
    const char* outer_;
};

}  // namespace ropsim
