// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace skinlod {

/// What a process of its own may use before it is stopped.
struct Limits {
  int cpu_seconds = 60;
  int wall_seconds = 600;                               // catches what waits for ever without computing
  std::uint64_t memory_bytes = std::uint64_t(1) << 30;  // beyond what this process has mapped already
};

/// Runs `work` in a child process and returns its bytes. The child can print nothing, leaves no core dump and
/// dies with us. An Error it throws arrives here as it was thrown. If it aborts, crashes, or passes a limit:
/// Error{Input} "`subject`: what happened: it is damaged or not what it says...". If no process can be had:
/// Error{Temporary}. Under AddressSanitizer, which maps terabytes, memory is not limited.
std::vector<std::byte> run_isolated(const std::string& subject, const Limits& limits,
                                    const std::function<std::vector<std::byte>()>& work);

}  // namespace skinlod
