#pragma once
/// How this house starts other programs: with signals as a program expects them, and no file that it is not
/// given.

#include <sys/types.h>

#include <string>
#include <vector>

namespace ballbar {

/// A file of ours becomes file `as` of the child.
struct SpawnFile {
  int fd;  ///< kNothing: /dev/null
  int as;
  static constexpr int kNothing = -1;
};

struct SpawnSpec {
  std::vector<std::string> command;  ///< program and arguments; PATH is searched where its name has no slash
  std::vector<SpawnFile> files;      ///< in this sequence; 0, 1 and 2 are ours where they do not stand here
  bool apart = false;                ///< in a process group of its own
};

/// @param pid  of the child; unchanged where there is none
/// @return 0 or errno
int spawn(SpawnSpec spec, pid_t& pid);

}  // namespace ballbar
