// SPDX-License-Identifier: MIT
#include <fcntl.h>
#include <unistd.h>

#include <csignal>
#include <exception>
#include <initializer_list>
#include <iostream>
#include <new>

#include "formats/file.h"
#include "pipeline/error.h"
#include "tools/run.h"

namespace {

// Leaves nothing half-written, then dies of the signal itself, so that shells and build systems see 130 or
// 143.
void stop(int signal) {
  skinlod::remove_unfinished_files();
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

void clean_up_on_signals() {
  for (const int signal : {SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGPIPE, SIGXCPU}) {
    if (std::signal(signal, stop) == SIG_IGN) std::signal(signal, SIG_IGN);  // nohup stays nohup
  }
  std::signal(SIGXFSZ, SIG_IGN);  // a write beyond the limit then fails with a reason
}

// The next file that is opened would take the number of a standard stream that is closed, and results would
// go into it. Opened the wrong way round, the stream still fails.
void occupy_closed_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) < 0) open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
  }
}

}  // namespace

int main(int argc, char** argv) {
  using namespace skinlod;
  clean_up_on_signals();
  occupy_closed_streams();
  try {
    const std::vector<std::string> args(argv + (argc > 0), argv + argc);
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
