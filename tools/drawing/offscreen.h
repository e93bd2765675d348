// SPDX-License-Identifier: MIT
#pragma once

namespace skinlod {

/// An OpenGL 4.5 context without a screen, by EGL: Mesa's software renderer where there is no other. Current
/// on the thread that made it until it goes, and all OpenGL objects go with it. One at a time.
class Offscreen {
 public:
  /// Throws Error{Access} where there is no such driver.
  Offscreen();
  ~Offscreen();
  Offscreen(const Offscreen&) = delete;
  Offscreen& operator=(const Offscreen&) = delete;

 private:
  void* display_;  // EGLDisplay
};

}  // namespace skinlod
