/** @file
 * A page with the picture of a render as it grows, served by the program itself.
 */
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "recurse/core/image/image.h"
#include "recurse/render/render.h"

namespace recurse::apps {

/** While it lives, the page can be opened; what it shows is the newest picture and progress it was given. */
class LiveServer {
 public:
  /** `address` is HOST, HOST:PORT or :PORT; port 0 or none: any that is free. `hosts` are names of this
   * machine that browsers may call it besides localhost and its numbers. `stop` is called when the person
   * wants to keep what there is. Throws Error where the address cannot be listened at. */
  LiveServer(const std::string& address, const std::vector<std::string>& hosts, const std::string& title,
             std::function<void()> stop);
  ~LiveServer();

  /** The address of the page; whoever knows it may watch and stop the render. */
  const std::string& url() const;
  /** Seconds that developing a picture took, the last time. */
  double cost() const;
  void show(Image picture);
  void show(const RenderProgress& progress);
  /** A render begins, which may be another one: nobody has asked yet that it ends. */
  void begin();
  /** The render has ended: a page that is open has so many seconds to fetch the last picture. */
  void finish(double patience);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts;
};

constexpr const char* LOOPBACK = "127.0.0.1";

} // namespace recurse::apps
