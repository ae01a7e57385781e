/** @file
 * The start of the program takes longer than most tests, because OpenImageIO loads 250 libraries. So a
 * launcher forks off before the tests, and forks again for each run. Tests that run RECURSE_PROGRAM in a
 * shell check its own start and exit status.
 */
#include "program.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <system_error>

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/wait.h>

#include "apps/program.h"

extern "C" __attribute__((weak)) void __lsan_do_leak_check(); // defined under AddressSanitizer

namespace programTesting {

namespace {

int launcher = -1; // socket to the launcher

[[noreturn]] void fail(const char* what) { throw std::system_error(errno, std::generic_category(), what); }

/** Libraries start threads when they are loaded (log4cplus does). Waits until these threads are idle before
 * the launcher forks: a lock of one of them would never be released in the child. */
void awaitRest() {
  const std::string self = std::to_string(::getpid());
  const auto busy = [&](const std::filesystem::directory_entry& thread) {
    const std::string stat = contents(thread.path() / "stat"); // number (name) state
    return thread.path().filename() != self && stat.find(") S") == std::string::npos;
  };
  while (std::ranges::any_of(std::filesystem::directory_iterator("/proc/self/task"), busy))
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

/** Runs in the process of a run: `words` are the folder and the arguments, each terminated by a zero byte. */
[[noreturn]] void runHere(std::string words) {
  const char* const folder = words.c_str();
  std::vector<char*> argv;
  for (char* word = words.data() + std::strlen(folder) + 1; word < words.data() + words.size();
       word += std::strlen(word) + 1)
    argv.push_back(word);
  argv.push_back(nullptr);
  if (::chdir(folder) != 0) ::_exit(126);
  const int console = ::dup(STDERR_FILENO);
  ::dup2(::open(".stdout", O_WRONLY | O_CREAT | O_TRUNC, 0600), STDOUT_FILENO);
  ::dup2(::open(".stderr", O_WRONLY | O_CREAT | O_TRUNC, 0600), STDERR_FILENO);
  const int status = recurse::apps::program(int(argv.size()) - 1, argv.data());
  std::fflush(nullptr);
  if (status == 0 && __lsan_do_leak_check) { // the leak check takes longer than all runs that end in an error
    ::dup2(console, STDERR_FILENO);
    __lsan_do_leak_check();
  }
  ::_exit(status); // the exit handler of log4cplus would wait for threads that do not exist in this process
}

/** Launcher: responds to each command with the process id, and at the end of the process with its status. */
[[noreturn]] void serve(int socket) {
  std::string words(1 << 16, '\0');
  for (ssize_t size; (size = ::recv(socket, words.data(), words.size(), 0)) > 0;) {
    const pid_t child = ::fork();
    if (child < 0) break;
    if (child == 0) {
      ::close(socket);
      runHere(words.substr(0, size_t(size)));
    }
    ::send(socket, &child, sizeof child, MSG_NOSIGNAL);
    int status = 0;
    ::waitpid(child, &status, 0);
    ::send(socket, &status, sizeof status, MSG_NOSIGNAL);
  }
  ::_exit(0); // the tests are finished
}

void startLauncher() {
  int sockets[2];
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, sockets) != 0) fail("socketpair");
  awaitRest();
  const pid_t child = ::fork();
  if (child < 0) fail("fork");
  ::close(sockets[child == 0 ? 0 : 1]);
  if (child == 0) serve(sockets[1]);
  launcher = sockets[0];
}

template <class T> T answer() {
  T value{};
  if (::recv(launcher, &value, sizeof value, 0) != sizeof value) fail("the launcher does not answer");
  return value;
}

} // namespace

Outcome runIn(const std::string& folder, const std::vector<std::string>& arguments,
              const std::function<void(pid_t)>& meanwhile) {
  const auto start = std::chrono::steady_clock::now();
  std::string words = folder + '\0' + "recurse" + '\0';
  for (const std::string& a : arguments) words += a + '\0';
  if (::send(launcher, words.data(), words.size(), MSG_NOSIGNAL) < 0) fail("the launcher does not listen");
  const auto child = answer<pid_t>();
  if (meanwhile) meanwhile(child);
  const int status = answer<int>();
  Outcome result;
  result.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  for (const auto& [name, text] : {std::pair(".stdout", &result.out), std::pair(".stderr", &result.err)}) {
    const std::string path = folder + "/" + name;
    *text = contents(path);
    std::filesystem::remove(path);
  }
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

} // namespace programTesting

int main(int argc, char** argv) {
  programTesting::startLauncher();
  ::testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
