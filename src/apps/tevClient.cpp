/** @file
 * Packets for tev, and the connection to it.
 */
#include "apps/tevClient.h"

#include <bit>
#include <cerrno>
#include <cstdint>
#include <cstring>

#include <netdb.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include "apps/optionText.h"
#include "recurse/core/error.h"

namespace recurse::apps {

namespace {

/** A packet as it grows. */
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
  /** With its length filled in. */
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
constexpr timeval TIMEOUT{3, 0}; // of connecting and sending

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

TevClient::TevClient(const std::string& address, std::string imageName) : imageName(std::move(imageName)) {
  const size_t colon = address.rfind(':');
  if (colon == std::string::npos || colon == 0)
    badUsage("--display-server: '" + address + "' is not HOST:PORT, such as localhost:14158");
  host = address.substr(0, colon);
  port = std::to_string(parseCount("--display-server", address.substr(colon + 1), 1, 65535));
}

TevClient::~TevClient() { disconnect(); }

void TevClient::connect() {
  addrinfo wanted{}, *found = nullptr;
  wanted.ai_socktype = SOCK_STREAM;
  const auto fail = [&](const std::string& why) {
    throw Error("--display-server: " + host + ":" + port + ": " + why + "; the render goes on without it");
  };
  if (const int status = ::getaddrinfo(host.c_str(), port.c_str(), &wanted, &found); status != 0)
    fail(::gai_strerror(status));
  int reason = 0;
  for (const addrinfo* a = found; a && socket < 0; a = a->ai_next) {
    socket = ::socket(a->ai_family, a->ai_socktype | SOCK_CLOEXEC, a->ai_protocol);
    if (socket < 0) continue;
    ::setsockopt(socket, SOL_SOCKET, SO_SNDTIMEO, &TIMEOUT, sizeof TIMEOUT);
    if (::connect(socket, a->ai_addr, a->ai_addrlen) == 0) break;
    reason = errno;
    disconnect();
  }
  ::freeaddrinfo(found);
  // What connecting says that took longer than TIMEOUT.
  if (socket < 0) fail(reason == EINPROGRESS ? "no answer" : std::strerror(reason));
}

void TevClient::disconnect() {
  if (socket >= 0) ::close(socket);
  socket = -1;
}

void TevClient::sendAll(const std::vector<unsigned char>& bytes) {
  for (size_t sent = 0; sent < bytes.size();) {
    const ssize_t count = ::send(socket, &bytes[sent], bytes.size() - sent, MSG_NOSIGNAL);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      const int reason = errno;
      disconnect(); // half a packet would put the stream out of step
      throw Error("--display-server: " + host + ":" + port + ": " + std::strerror(reason) +
                  "; the render goes on without it");
    }
    sent += size_t(count);
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
