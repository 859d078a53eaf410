// The style sheet of reports (report_style.css), part of the program.
#pragma once

namespace ropsim {
const char* report_style();
}
