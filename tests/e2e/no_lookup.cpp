// Preloaded into a program, this makes looking up a host's name hang, as it does where a name
// server does not answer. The file that POINTREEL_LOOKUP_BEGUN names tells that it has begun.

#include <cstdlib>

#include <fcntl.h>
#include <netdb.h>
#include <unistd.h>

extern "C" int getaddrinfo(const char*, const char*, const addrinfo*, addrinfo**) {
  if (const char* file = std::getenv("POINTREEL_LOOKUP_BEGUN"))
    ::close(::open(file, O_WRONLY | O_CREAT | O_CLOEXEC, 0666));
  for (;;) ::pause();
}
