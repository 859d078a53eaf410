// The files in analysis/report/ and the plotting library, part of the program.
#pragma once

namespace ropsim {

const char* report_style();            // style sheets
const char* report_library();          // Chart.js, minified, with its notice
const char* report_library_license();  // its licence in full
const char* report_scripts();          // the page's own

}  // namespace ropsim
