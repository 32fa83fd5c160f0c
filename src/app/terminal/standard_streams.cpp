#include "app/terminal/standard_streams.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

namespace mimbre::app {
namespace {

/// open() gives the lowest number that is free: those of the streams come first, and are not given back.
void take_closed_descriptors() {
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream)
    if (fcntl(stream, F_GETFD) < 0 && errno == EBADF)
      open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);  // the wrong way round: using it fails
}

#ifdef __GLIBC__
/// All of it counts as written, whether it could be or not.
ssize_t write_or_drop(void*, const char* text, size_t size) {
  for (size_t sent = 0; sent < size;) {
    const ssize_t count = write(STDERR_FILENO, text + sent, size - sent);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    sent += static_cast<size_t>(count);
  }
  return static_cast<ssize_t>(size);
}

void drop_what_stderr_cannot_take() {
  std::FILE* const forgiving = fopencookie(nullptr, "w", {nullptr, write_or_drop, nullptr, nullptr});
  if (!forgiving) return;
  std::setvbuf(forgiving, nullptr, _IOLBF, BUFSIZ);
  stderr = forgiving;
}
#else
void drop_what_stderr_cannot_take() {}
#endif

}  // namespace

void prepare_standard_streams() {
  take_closed_descriptors();
  drop_what_stderr_cannot_take();
}

}  // namespace mimbre::app
