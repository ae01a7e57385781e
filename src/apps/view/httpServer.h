/** @file
 * A small server of HTTP/1.1, for pages of this program and their scripts.
 */
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <list>
#include <map>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "apps/view/networkAddress.h"

namespace recurse::apps {

struct HttpRequest {
  std::string method, path;                      ///< path: up to the '?', as it was sent
  std::map<std::string, std::string> parameters; ///< after the '?', decoded
  std::map<std::string, std::string> headers;    ///< by their names in lower case
  std::string localHost; ///< numeric address by which the client has reached this machine, as in URLs

  /** A header's value; empty where it is missing. */
  std::string header(const std::string& name) const;
};

struct HttpAnswer {
  int status = 200;
  std::string type = "text/plain; charset=utf-8", body;
  std::vector<std::pair<std::string, std::string>> headers;
};

/**
 * Answers requests without a body, one on each connection, from a thread of its own. Memory, connections and
 * time are bounded for any client: a request has 8 kB and 5 s, an answer 60 s. With too many connections or
 * unread answers, the oldest one is closed.
 */
class HttpServer {
 public:
  using Handler = std::function<HttpAnswer(const HttpRequest&)>;

  /** Listens at the address; port 0: any free port. `handler` is called in the server's thread, and must not
   * throw. Throws Error if the server cannot listen at the address. */
  HttpServer(const NetworkAddress& address, Handler handler);
  /** Closes all connections, in any state. */
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  int port() const { return listeningPort; }
  /** True while an answer is made, or has not been taken by its client. */
  bool isAnswering() const { return unsent > 0; }

 private:
  using Clock = std::chrono::steady_clock;
  struct Connection {
    int socket = -1;
    Clock::time_point deadline;
    std::string request, answer;
    size_t sent = 0;
    bool isAnswered = false;
  };
  using Connections = std::list<Connection>; // the oldest first

  void listen(const NetworkAddress& address);
  void serve();
  void accept();
  void closeOldest(bool ofAnswered);
  /** Closes a connection. Returns the next one. */
  Connections::iterator close(Connections::iterator connection);
  /** False if the connection has ended. */
  bool receive(Connection& connection);
  bool send(Connection& connection);
  void answer(Connection& connection);

  const Handler handler;
  int listener = -1, wake = -1; ///< wake: an event that ends the thread's waiting
  int listeningPort = 0;
  Connections connections;
  std::atomic<int> unsent{0};
  std::atomic<bool> ends{false};
  std::thread thread;
};

} // namespace recurse::apps
