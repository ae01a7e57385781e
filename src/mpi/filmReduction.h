/** @file
 * The sum of the ranks' films.
 */
#pragma once

#include <cstddef>
#include <vector>

#include <mpi.h>

#include "recurse/model/film/film.h"

namespace recurse::apps {

/** Adds up the films of all ranks at the leader, while they do other things. */
class FilmReduction {
 public:
  explicit FilmReduction(Film& shape);
  ~FilmReduction();
  FilmReduction(const FilmReduction&) = delete;
  FilmReduction& operator=(const FilmReduction&) = delete;

  /** `sum`: at the leader, where it is to go; null elsewhere. Both stay until it has ended. */
  void start(Film& own, Film* sum);
  bool isActive() const { return active; }
  /** True when it has just ended. */
  bool ended();

 private:
  std::vector<MPI_Datatype> types;
  std::vector<MPI_Op> operations;
  std::vector<MPI_Request> requests;
  bool active = false;
};

} // namespace recurse::apps
