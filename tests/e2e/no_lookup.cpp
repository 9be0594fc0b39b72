// Preloaded into a program, this makes looking up a host's name hang, as it does where a name
// server does not answer.

#include <netdb.h>
#include <unistd.h>

extern "C" int getaddrinfo(const char*, const char*, const addrinfo*, addrinfo**) {
  for (;;) ::pause();
}
