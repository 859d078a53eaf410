// What a user is told when code that is not ours takes the process down.
#include "base/crash_remark.h"

#include <atomic>

namespace ropsim {
namespace {

// Signal handlers read it: constructed before main().
constinit std::atomic<const char*> remark_in_force{nullptr};

}  // namespace

CrashRemark::CrashRemark(const char* remark) : outer_(remark_in_force.exchange(remark)) {}

CrashRemark::~CrashRemark() {
    remark_in_force = outer_;
}

const char* CrashRemark::current() {
    return remark_in_force;
}

void CrashRemark::forget() {
    remark_in_force = nullptr;
}

}  // namespace ropsim
