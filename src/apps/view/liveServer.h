/** @file
 * A page with the picture of a render as it grows, served by the program itself.
 */
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "apps/view/pixelQueries.h"
#include "recurse/core/image/image.h"
#include "recurse/render/render.h"

namespace recurse::apps {

/** Serves the live page during its lifetime. The page shows the newest picture and progress. */
class LiveServer {
 public:
  /** `address`: HOST, HOST:PORT or :PORT; port 0 or none: any free port. `hosts`: names by which browsers may
   * reach this machine, besides localhost and its numeric addresses. `stop` is called when the user stops the
   * render on the page. Throws Error if the server cannot listen at the address. */
  LiveServer(const std::string& address, const std::vector<std::string>& hosts, const std::string& title,
             std::function<void()> stop);
  ~LiveServer();

  /** The address of the page; whoever knows it may watch and stop the render. */
  const std::string& url() const;
  /** Duration of the latest development of a picture [s]. */
  double cost() const;
  void show(Image picture);
  void show(const RenderProgress& progress);
  /** Sets what answers questions about pixels; null: nobody does. */
  void setQueries(std::shared_ptr<PixelQueries> queries);
  /** Notes the start of a render, possibly one of several, without a request to stop it. */
  void begin();
  /** Notes the end of the render. An open page has `patience` [s] to fetch the last picture. */
  void finish(double patience);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts;
};

constexpr const char* LOOPBACK = "127.0.0.1";

} // namespace recurse::apps
