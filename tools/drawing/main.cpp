// SPDX-License-Identifier: MIT
#include <exception>
#include <iostream>
#include <string>
#include <vector>

#include "pipeline/error.h"
#include "tools/drawing/sheet.h"

int main(int argc, char** argv) {
  using namespace skinlod;
  try {
    const std::vector<std::string> args(argv + (argc > 0), argv + argc);
    return draw_sheet(args, std::cout);
  } catch (const Error& e) {
    std::cerr << "skinlod_sheet: " << e.what() << '\n';
    return int(e.fault);
  } catch (const std::exception& e) {
    std::cerr << "skinlod_sheet: " << e.what() << '\n';
    return int(Fault::Ours);
  }
}
