/** @file
 * Network protocol of the viewer tev: an image is created once, and its pixels are updated repeatedly.
 */
#pragma once

#include <atomic>
#include <chrono>
#include <string>
#include <vector>

#include "apps/view/networkAddress.h"
#include "recurse/core/image/image.h"

namespace recurse::apps {

/** Packets of the protocol: length in bytes with itself, type, payload; little-endian. */
namespace tev {
std::vector<unsigned char> createImage(const std::string& name, int width, int height,
                                       const std::vector<std::string>& channels);
/** Packet with one channel of all pixels. */
std::vector<unsigned char> updateImage(const std::string& name, const Image& picture, size_t channel);
} // namespace tev

/** Sends pictures to a display server. Connects when there is something to send, and again after the
 * connection was lost. */
class TevClient {
 public:
  using Clock = std::chrono::steady_clock;

  /** `address` is HOST:PORT; throws Error (BAD_USAGE) where it is not. */
  TevClient(const std::string& address, std::string imageName);
  ~TevClient();
  TevClient(const TevClient&) = delete;
  TevClient& operator=(const TevClient&) = delete;

  /** Sends a picture. Throws Error if the server cannot be reached, or takes no data for three seconds. */
  void send(const Image& picture);
  /** Sets a deadline for all sending, current and later. Callable from any thread. */
  void endBy(Clock::time_point time) { deadline = time; }

 private:
  void connect();
  void disconnect();
  void sendAll(const std::vector<unsigned char>& bytes);
  /** Waits until the socket takes data. False after PATIENCE or at the deadline. */
  bool awaitRoom() const;
  [[noreturn]] void fail(const std::string& why);

  NetworkAddress address;
  std::string imageName;
  std::atomic<Clock::time_point> deadline{Clock::time_point::max()};
  int socket = -1;
};

} // namespace recurse::apps
