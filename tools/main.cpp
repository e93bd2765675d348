// SPDX-License-Identifier: MIT
#include <exception>
#include <iostream>
#include <new>

#include "pipeline/error.h"
#include "tools/run.h"

int main(int argc, char** argv) {
  using namespace skinlod;
  try {
    const std::vector<std::string> args(argv + 1, argv + argc);
    return run(args, std::cout, std::cerr);
  } catch (const Error& e) {
    std::cerr << "skinlod: " << e.what() << '\n';
    return int(e.fault);
  } catch (const std::bad_alloc&) {
    std::cerr << "skinlod: out of memory: give the process more, or cook fewer poses at once\n";
    return int(Fault::Temporary);
  } catch (const std::exception& e) {
    std::cerr << "skinlod: internal error: " << e.what() << "\nPlease report this with the command line.\n";
    return int(Fault::Ours);
  }
}
