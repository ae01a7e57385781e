/** @file
 * Pointer to the cluster of the process.
 */
#include "apps/run/cluster.h"

namespace recurse::apps {

namespace {
Cluster* theCluster = nullptr;
} // namespace

Cluster* cluster() { return theCluster; }
void setCluster(Cluster* c) { theCluster = c; }

} // namespace recurse::apps
