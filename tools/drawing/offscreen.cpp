// SPDX-License-Identifier: MIT
#include "tools/drawing/offscreen.h"

#define GL_GLEXT_PROTOTYPES
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/glcorearb.h>

#include "pipeline/error.h"

namespace skinlod {

Offscreen::Offscreen()
    : display_(eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr)) {
  const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION,
                            4,
                            EGL_CONTEXT_MINOR_VERSION,
                            5,
                            EGL_CONTEXT_OPENGL_PROFILE_MASK,
                            EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                            EGL_NONE};
  EGLContext context = EGL_NO_CONTEXT;
  if (eglInitialize(display_, nullptr, nullptr) && eglBindAPI(EGL_OPENGL_API)) {
    context = eglCreateContext(display_, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, version);
  }
  if (!eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context) || context == EGL_NO_CONTEXT) {
    throw Error{Fault::Access,
                "EGL: no OpenGL 4.5 without a screen: install libegl-mesa0 and libgl1-mesa-dri"};
  }
  // Without a screen there is no framebuffer, and no draw call works without one, even if it draws nothing.
  GLuint frame = 0;
  glCreateFramebuffers(1, &frame);
  glNamedFramebufferParameteri(frame, GL_FRAMEBUFFER_DEFAULT_WIDTH, 1);
  glNamedFramebufferParameteri(frame, GL_FRAMEBUFFER_DEFAULT_HEIGHT, 1);
  glBindFramebuffer(GL_FRAMEBUFFER, frame);
}

Offscreen::~Offscreen() {
  eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglTerminate(display_);
}

}  // namespace skinlod
