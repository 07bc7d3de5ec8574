#include "bus/spawn.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>

extern char** environ;

namespace ballbar {

int spawn(SpawnSpec spec, pid_t& pid) {
  std::vector<char*> words;
  words.reserve(spec.command.size() + 1);
  for (std::string& word : spec.command) words.push_back(word.data());
  words.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  int last = STDERR_FILENO;
  for (const SpawnFile& file : spec.files) {
    last = std::max(last, file.as);
    if (file.fd == SpawnFile::kNothing)
      posix_spawn_file_actions_addopen(&files, file.as, "/dev/null", O_RDWR, 0);
    else
      posix_spawn_file_actions_adddup2(&files, file.fd, file.as);  // also where both are the same
  }
  posix_spawn_file_actions_addclosefrom_np(&files, last + 1);  // liblcm's sockets are not close-on-exec
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes, static_cast<short>(POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF |
                                                           (spec.apart ? POSIX_SPAWN_SETPGROUP : 0)));
  pid_t child = -1;
  const int error = posix_spawnp(&child, words[0], &files, &attributes, words.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  if (error == 0) pid = child;
  return error;
}

}  // namespace ballbar
