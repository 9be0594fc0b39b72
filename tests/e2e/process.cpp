#include "tests/e2e/process.h"

#include <algorithm>
#include <chrono>
#include <string_view>

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/paths.h"
#include "tests/wait.h"

extern char** environ;

namespace pointreel::e2e {
namespace {

struct Pipe {
  int read = -1, write = -1;
  Pipe() {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) == 0) {
      read = ends[0];
      write = ends[1];
    }
  }
};

pid_t spawn(const std::string& program, std::vector<std::string> arguments, int out, int err,
            const Surroundings& surroundings = {}) {
  const std::string path = program_folder() / program;  // an absolute path stays as it is
  arguments.insert(arguments.begin(), program);
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  std::vector<std::string> environment = surroundings.environment;
  std::vector<char*> variables;
  for (std::string& variable : environment) variables.push_back(variable.data());
  for (char** own = environ; *own != nullptr; ++own) {
    const std::string_view variable(*own);
    const std::string_view name = variable.substr(0, variable.find('=') + 1);
    const bool replaced = std::any_of(environment.begin(), environment.end(),
                                      [&](const std::string& by) { return by.starts_with(name); });
    if (!replaced) variables.push_back(*own);
  }
  variables.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, out, 1);
  if (err >= 0) posix_spawn_file_actions_adddup2(&actions, err, 2);
  if (!surroundings.folder.empty())
    posix_spawn_file_actions_addchdir_np(&actions, surroundings.folder.c_str());
  pid_t pid = -1;
  if (posix_spawn(&pid, path.c_str(), &actions, nullptr, argv.data(), variables.data()) != 0)
    pid = -1;
  posix_spawn_file_actions_destroy(&actions);
  return pid;
}

int code_of(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status); }

/// Appends the available bytes. Returns false at the end of the stream.
bool drain(int fd, std::string& to) {
  char buffer[4096];
  const ssize_t n = read(fd, buffer, sizeof(buffer));
  if (n > 0) to.append(buffer, static_cast<std::size_t>(n));
  return n > 0;
}

}  // namespace

Outcome run(const std::string& program, const std::vector<std::string>& arguments, int seconds) {
  const Pipe out, err;
  const pid_t pid = spawn(program, arguments, out.write, err.write);
  close(out.write);
  close(err.write);
  Outcome outcome;
  if (pid < 0) {
    outcome.err = "cannot start " + program;
    return outcome;
  }
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(seconds);
  bool out_open = true, err_open = true, killed = false;
  while (out_open || err_open) {
    pollfd fds[2] = {{out_open ? out.read : -1, POLLIN, 0}, {err_open ? err.read : -1, POLLIN, 0}};
    poll(fds, 2, 200);
    if (fds[0].revents != 0) out_open = drain(out.read, outcome.out);
    if (fds[1].revents != 0) err_open = drain(err.read, outcome.err);
    if (!killed && std::chrono::steady_clock::now() > deadline) {
      kill(pid, SIGKILL);
      killed = true;
    }
  }
  close(out.read);
  close(err.read);
  int status = 0;
  rusage usage{};
  wait4(pid, &status, 0, &usage);
  outcome.exit_code = code_of(status);
  outcome.peak_mib = static_cast<double>(usage.ru_maxrss) / 1024.0;  // Linux counts in KiB
  return outcome;
}

Background::Background(const std::string& program, const std::vector<std::string>& arguments,
                       const Surroundings& surroundings) {
  const Pipe out;
  const int err = surroundings.err.empty() ? -1
                                           : open(surroundings.err.c_str(),
                                                  O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  pid_ = spawn(program, arguments, out.write, err, surroundings);
  if (err >= 0) close(err);
  close(out.write);
  out_ = out.read;
}

Background::~Background() {
  end(SIGTERM);
  close(out_);
}

std::string Background::first_line() {
  std::string text;
  while (text.find('\n') == std::string::npos && drain(out_, text)) {
  }
  return text.substr(0, text.find('\n'));
}

bool Background::running() const {
  siginfo_t ended{};
  return pid_ > 0 &&
         waitid(P_PID, static_cast<id_t>(pid_), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 &&
         ended.si_pid == 0;
}

int Background::end(int signal) {
  if (pid_ <= 0) return -1;
  if (signal != 0) kill(pid_, signal);
  int status = 0;
  if (!wait_until([&] { return waitpid(pid_, &status, WNOHANG) != 0; })) {
    kill(pid_, SIGKILL);
    waitpid(pid_, &status, 0);
  }
  pid_ = -1;
  return code_of(status);
}

}  // namespace pointreel::e2e
