/** @file
 * Error thrown by interrupted work.
 */
#include "recurse/core/threads/interrupt.h"

namespace recurse {

Interrupted::Interrupted()
    : Error("interrupted before the first sample: nothing was written", ExitStatus::INTERRUPTED) {}

} // namespace recurse
