/** @file
 * HTTP server, which waits for its connections by poll(2).
 */
#include "apps/view/httpServer.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <new>
#include <optional>

#include <netdb.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include "recurse/core/io/error.h"
#include "recurse/core/io/text.h"

namespace recurse::apps {

namespace {

constexpr size_t MAX_CONNECTIONS = 32, MAX_UNSENT = 4, MAX_REQUEST_BYTES = 8192;
constexpr std::chrono::seconds REQUEST_TIME{5}, ANSWER_TIME{60};
constexpr const char* END_OF_HEADERS = "\r\n\r\n";

const char* reasonOf(int status) {
  switch (status) {
  case 200:
    return "OK";
  case 204:
    return "No Content";
  case 400:
    return "Bad Request";
  case 403:
    return "Forbidden";
  case 404:
    return "Not Found";
  case 431:
    return "Request Header Fields Too Large";
  default:
    return "Internal Server Error";
  }
}

std::string trimmed(const std::string& text) {
  const size_t begin = text.find_first_not_of(" \t"), end = text.find_last_not_of(" \t");
  return begin == std::string::npos ? "" : text.substr(begin, end + 1 - begin);
}

/** Decodes "+" and "%20" of a query. */
std::string decoded(std::string text) {
  std::replace(text.begin(), text.end(), '+', ' ');
  return percentDecoded(text);
}

/** Parts of a text between separators. */
std::vector<std::string> pieces(const std::string& text, const std::string& separator) {
  std::vector<std::string> out;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find(separator, begin), text.size());
    out.push_back(text.substr(begin, end - begin));
    begin = end + separator.size();
  }
  return out;
}

/** Parses the line and the headers of a request; none if they are not HTTP. */
std::optional<HttpRequest> parseRequest(const std::string& head) {
  const std::vector<std::string> lines = pieces(head, "\r\n"), words = pieces(lines[0], " ");
  if (words.size() != 3 || !words[1].starts_with('/') || !words[2].starts_with("HTTP/1.")) return {};
  HttpRequest request;
  request.method = words[0];
  const size_t question = std::min(words[1].find('?'), words[1].size());
  request.path = words[1].substr(0, question);
  if (question < words[1].size())
    for (const std::string& pair : pieces(words[1].substr(question + 1), "&")) {
      const size_t equals = std::min(pair.find('='), pair.size());
      request.parameters[decoded(pair.substr(0, equals))] =
          decoded(pair.substr(std::min(equals + 1, pair.size())));
    }
  for (size_t i = 1; i < lines.size(); ++i) {
    const size_t colon = lines[i].find(':');
    if (colon == std::string::npos) return {};
    const std::string name = lowerCase(lines[i].substr(0, colon));
    if (!request.headers.emplace(name, trimmed(lines[i].substr(colon + 1))).second && name == "host")
      return {};
  }
  return request;
}

/** Numeric address of the local end of a connection, as in URLs. */
std::string localHost(int socket) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  std::array<char, NI_MAXHOST> text{};
  if (::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size) != 0 ||
      ::getnameinfo(reinterpret_cast<sockaddr*>(&address), size, text.data(), text.size(), nullptr, 0,
                    NI_NUMERICHOST) != 0)
    return {};
  std::string host = text.data();
  if (host.starts_with("::ffff:")) host = host.substr(7); // IPv4 at a socket of IPv6
  return NetworkAddress{host}.hostText();
}

} // namespace

std::string HttpRequest::header(const std::string& name) const {
  const auto found = headers.find(name);
  return found == headers.end() ? "" : found->second;
}

HttpServer::HttpServer(const NetworkAddress& address, Handler handler) : handler(std::move(handler)) {
  listen(address);
  thread = std::thread([this] { serve(); });
}

HttpServer::~HttpServer() {
  ends = true;
  const uint64_t one = 1;
  if (::write(wake, &one, sizeof one) == sizeof one) thread.join();
  for (const Connection& c : connections) ::close(c.socket);
  ::close(listener);
  ::close(wake);
}

void HttpServer::listen(const NetworkAddress& address) {
  addrinfo wanted{}, *found = nullptr;
  wanted.ai_socktype = SOCK_STREAM;
  wanted.ai_flags = AI_PASSIVE;
  if (::getaddrinfo(address.host.c_str(), std::to_string(address.port).c_str(), &wanted, &found) == 0) {
    const std::unique_ptr<addrinfo, void (*)(addrinfo*)> owner(found, ::freeaddrinfo);
    for (const addrinfo* a = found; a && listener < 0; a = a->ai_next) {
      const int socket =
          ::socket(a->ai_family, a->ai_socktype | SOCK_CLOEXEC | SOCK_NONBLOCK, a->ai_protocol);
      const int yes = 1;
      ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
      if (::bind(socket, a->ai_addr, a->ai_addrlen) == 0 && ::listen(socket, int(MAX_CONNECTIONS)) == 0)
        listener = socket;
      else if (socket >= 0)
        ::close(socket);
    }
  }
  wake = ::eventfd(0, EFD_CLOEXEC);
  if (listener < 0 || wake < 0) {
    if (wake >= 0) ::close(wake);
    throw Error("cannot listen at " + (address.port ? address.text() : address.hostText()) +
                "; the port is in use, or this machine does not have the address");
  }
  sockaddr_storage bound{};
  socklen_t size = sizeof bound;
  std::array<char, NI_MAXSERV> port{};
  ::getsockname(listener, reinterpret_cast<sockaddr*>(&bound), &size);
  ::getnameinfo(reinterpret_cast<sockaddr*>(&bound), size, nullptr, 0, port.data(), port.size(),
                NI_NUMERICSERV);
  listeningPort = std::atoi(port.data());
}

void HttpServer::serve() {
  while (!ends) {
    std::vector<pollfd> waited = {{wake, POLLIN, 0}, {listener, POLLIN, 0}};
    Clock::time_point first = Clock::time_point::max();
    for (const Connection& c : connections) {
      waited.push_back({c.socket, static_cast<short>(c.isAnswered ? POLLOUT : POLLIN), 0});
      first = std::min(first, c.deadline);
    }
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(first - Clock::now()).count();
    const int timeout = connections.empty() ? -1 : static_cast<int>(std::max<int64_t>(left, 0));
    if (::poll(waited.data(), waited.size(), timeout) < 0 && errno != EINTR) return;
    size_t i = 2;
    for (auto c = connections.begin(); c != connections.end(); ++i) {
      const bool isReady = waited[i].revents != 0, isLate = Clock::now() > c->deadline;
      const bool goesOn = !isLate && (!isReady || (c->isAnswered ? send(*c) : receive(*c)));
      c = goesOn ? std::next(c) : close(c);
    }
    while (std::count_if(connections.begin(), connections.end(),
                         [](const Connection& c) { return c.isAnswered; }) > ptrdiff_t(MAX_UNSENT))
      closeOldest(true);
    if (waited[1].revents != 0) accept();
  }
}

void HttpServer::accept() {
  const int socket = ::accept4(listener, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
  if (socket < 0) { // the limit of open files may be reached
    if (errno == EMFILE || errno == ENFILE) std::this_thread::sleep_for(std::chrono::milliseconds(50));
    return;
  }
  if (connections.size() >= MAX_CONNECTIONS) closeOldest(false);
  connections.push_back({socket, Clock::now() + REQUEST_TIME, {}, {}, 0, false});
}

void HttpServer::closeOldest(bool ofAnswered) {
  const auto oldest = std::find_if(connections.begin(), connections.end(),
                                   [&](const Connection& c) { return c.isAnswered == ofAnswered; });
  close(oldest != connections.end() ? oldest : connections.begin());
}

HttpServer::Connections::iterator HttpServer::close(Connections::iterator connection) {
  ::close(connection->socket);
  if (connection->isAnswered) --unsent;
  return connections.erase(connection);
}

bool HttpServer::receive(Connection& connection) {
  std::array<char, MAX_REQUEST_BYTES> part;
  const ssize_t count = ::recv(connection.socket, part.data(), part.size(), 0);
  if (count < 0) return errno == EAGAIN || errno == EINTR;
  if (count == 0) return false;
  connection.request.append(part.data(), static_cast<size_t>(count));
  if (connection.request.size() <= MAX_REQUEST_BYTES &&
      connection.request.find(END_OF_HEADERS) == std::string::npos)
    return true;
  try {
    answer(connection);
  } catch (const std::bad_alloc&) { // memory is left to the render
    return false;
  }
  return send(connection);
}

void HttpServer::answer(Connection& connection) {
  connection.isAnswered = true;
  ++unsent;
  HttpAnswer out{400, {}, "This is no request that the program understands.\n", {}};
  const size_t end = connection.request.find(END_OF_HEADERS);
  if (end >= MAX_REQUEST_BYTES) {
    out.status = 431;
  } else if (std::optional<HttpRequest> request = parseRequest(connection.request.substr(0, end))) {
    request->localHost = localHost(connection.socket);
    out = handler(*request);
  }
  connection.request = {};
  std::string& text = connection.answer;
  text = "HTTP/1.1 " + std::to_string(out.status) + " " + reasonOf(out.status) + "\r\nConnection: close\r\n";
  if (!out.type.empty()) text += "Content-Type: " + out.type + "\r\n";
  if (out.status != 204) text += "Content-Length: " + std::to_string(out.body.size()) + "\r\n";
  for (const auto& [name, value] : out.headers) text += name + ": " + value + "\r\n";
  text += "\r\n" + out.body;
  connection.deadline = Clock::now() + ANSWER_TIME;
}

bool HttpServer::send(Connection& connection) {
  const std::string& text = connection.answer;
  while (connection.sent < text.size()) {
    const ssize_t count =
        ::send(connection.socket, &text[connection.sent], text.size() - connection.sent, MSG_NOSIGNAL);
    if (count < 0) return errno == EAGAIN || errno == EINTR;
    connection.sent += static_cast<size_t>(count);
  }
  ::shutdown(connection.socket, SHUT_WR);
  return false;
}

} // namespace recurse::apps
