/** @file
 * Packets for tev, and the connection to it.
 */
#include "apps/view/tevClient.h"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <memory>

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "apps/options/optionText.h"
#include "recurse/core/io/error.h"

namespace recurse::apps {

namespace {

/** Packet under construction. */
class Packet {
 public:
  explicit Packet(unsigned char type) : bytes(4) { bytes.push_back(type); }
  void addFlag(bool value) { bytes.push_back(value ? 1 : 0); }
  void addText(const std::string& text) {
    bytes.insert(bytes.end(), text.begin(), text.end());
    bytes.push_back(0);
  }
  void addInteger(int32_t value) { addWord(static_cast<uint32_t>(value)); }
  void addReal(float value) { addWord(std::bit_cast<uint32_t>(value)); }
  /** Complete packet, with its length filled in. */
  std::vector<unsigned char> finished() {
    for (size_t i = 0; i < 4; ++i) bytes[i] = static_cast<unsigned char>(bytes.size() >> (8 * i));
    return std::move(bytes);
  }

 private:
  void addWord(uint32_t word) {
    for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<unsigned char>(word >> shift));
  }
  std::vector<unsigned char> bytes;
};

constexpr unsigned char UPDATE_IMAGE = 3, CREATE_IMAGE = 4;
/** Longest wait for a server to take data, and interval between checks of the deadline. */
constexpr std::chrono::milliseconds PATIENCE{3000}, STEP{100};

} // namespace

namespace tev {

std::vector<unsigned char> createImage(const std::string& name, int width, int height,
                                       const std::vector<std::string>& channels) {
  Packet packet(CREATE_IMAGE);
  packet.addFlag(true); // to the front
  packet.addText(name);
  packet.addInteger(width);
  packet.addInteger(height);
  packet.addInteger(static_cast<int32_t>(channels.size()));
  for (const std::string& channel : channels) packet.addText(channel);
  return packet.finished();
}

std::vector<unsigned char> updateImage(const std::string& name, const Image& picture, size_t channel) {
  Packet packet(UPDATE_IMAGE);
  packet.addFlag(false);
  packet.addText(name);
  packet.addText(picture.channels[channel]);
  for (int value : {0, 0, picture.width, picture.height}) packet.addInteger(value);
  for (size_t i = channel; i < picture.pixels.size(); i += picture.channels.size())
    packet.addReal(picture.pixels[i]);
  return packet.finished();
}

} // namespace tev

TevClient::TevClient(const std::string& address, std::string imageName)
    : address(parseNetworkAddress("--display-server", address, "localhost:14158")),
      imageName(std::move(imageName)) {
  if (this->address.host.empty() || this->address.port == 0)
    badUsage("--display-server: '" + address + "' is not HOST:PORT, such as localhost:14158");
}

TevClient::~TevClient() { disconnect(); }

void TevClient::fail(const std::string& why) {
  disconnect(); // half a packet would put the stream out of step
  throw Error("--display-server: " + address.text() + ": " + why + "; the render continues without it");
}

bool TevClient::awaitRoom() const {
  const Clock::time_point patience = Clock::now() + PATIENCE;
  for (;;) {
    const auto left = std::min(patience, deadline.load()) - Clock::now();
    if (left <= Clock::duration::zero()) return false;
    // The deadline may be set meanwhile.
    const auto step = std::min(std::chrono::ceil<std::chrono::milliseconds>(left), STEP);
    pollfd waited{socket, POLLOUT, 0};
    if (::poll(&waited, 1, static_cast<int>(step.count())) > 0) return true;
  }
}

void TevClient::connect() {
  addrinfo wanted{}, *found = nullptr;
  wanted.ai_socktype = SOCK_STREAM;
  if (const int status =
          ::getaddrinfo(address.host.c_str(), std::to_string(address.port).c_str(), &wanted, &found);
      status != 0)
    fail(::gai_strerror(status));
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> owner(found, ::freeaddrinfo);
  std::string reason = "no answer";
  for (const addrinfo* a = found; a; a = a->ai_next) {
    socket = ::socket(a->ai_family, a->ai_socktype | SOCK_CLOEXEC | SOCK_NONBLOCK, a->ai_protocol);
    int error = ::connect(socket, a->ai_addr, a->ai_addrlen) == 0 ? 0 : errno;
    if (error == EINPROGRESS && awaitRoom()) {
      socklen_t size = sizeof error;
      ::getsockopt(socket, SOL_SOCKET, SO_ERROR, &error, &size);
    }
    if (error == 0) return;
    if (error != EINPROGRESS) reason = std::strerror(error);
    disconnect();
  }
  fail(reason);
}

void TevClient::disconnect() {
  if (socket >= 0) ::close(socket);
  socket = -1;
}

void TevClient::sendAll(const std::vector<unsigned char>& bytes) {
  for (size_t sent = 0; sent < bytes.size();) {
    if (!awaitRoom()) fail("it does not receive data");
    const ssize_t count = ::send(socket, &bytes[sent], bytes.size() - sent, MSG_NOSIGNAL);
    if (count < 0 && errno != EINTR && errno != EAGAIN) fail(std::strerror(errno));
    if (count > 0) sent += size_t(count);
  }
}

void TevClient::send(const Image& picture) {
  if (socket < 0) {
    connect();
    sendAll(tev::createImage(imageName, picture.width, picture.height, picture.channels));
  }
  for (size_t channel = 0; channel < picture.channels.size(); ++channel)
    sendAll(tev::updateImage(imageName, picture, channel));
}

} // namespace recurse::apps
