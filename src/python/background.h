/** @file
 * Work of the renderer in a thread beside Python's, so that other Python threads run and Ctrl-C is heard.
 */
#pragma once

#include <functional>

namespace recurse::python {

/**
 * Runs `work` in a thread of its own, without Python's lock, and waits for it. Meanwhile calls `look` with
 * Python's lock ten times a second, in the calling thread. Where `look` throws, and on Ctrl-C, has
 * checkInterrupted() throw in the work, calls `stop`, and throws that once the work has ended. Throws what
 * the work throws.
 */
void runInBackground(const std::function<void()>& work, const std::function<void()>& look,
                     const std::function<void()>& stop);

} // namespace recurse::python
