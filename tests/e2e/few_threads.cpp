// Preloaded into a program, this lets it start as many threads as POINTREEL_THREADS says, as where
// a user's processes are limited.

#include <atomic>
#include <cerrno>
#include <cstdlib>

#include <dlfcn.h>
#include <pthread.h>

extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes,
                              void* (*run)(void*), void* argument) {
  static std::atomic<int> left = std::atoi(std::getenv("POINTREEL_THREADS"));
  static auto* const create =
      reinterpret_cast<decltype(&pthread_create)>(::dlsym(RTLD_NEXT, "pthread_create"));
  return left-- > 0 ? create(thread, attributes, run, argument) : EAGAIN;
}
