# What `demo`, `telepresence` and `page` share: they build the programs, serve on loopback and play.
. "$(dirname "${BASH_SOURCE[0]}")/shared.sh"
bin=build/bin out=build/demo url='' native=pointreel_server_without_page

build_programs() {  # all but the page, which takes minutes more: `page` builds it
  say "install missing packages"
  common/run/install programs
  say "build the programs"
  attended common/run/compile programs pointreel pointreel-synth $native
}

make_sequence() {  # NAME [OPTION...]: into $out/NAME, unless it is there
  if [[ $out/$1 -nt $bin/pointreel-synth ]]; then
    echo "It is there already: $out/$1"
  else
    attended $bin/pointreel-synth "$1" -o "$out/$1" --force "${@:2}"
  fi
}

serve() {  # SERVER ARGUMENTS...: starts this server and sets `server` and `url`
  local log=$out/$1.log
  : >"$log"
  "$bin/$1" serve "${@:2}" --listen 127.0.0.1:0 >"$log" 2>&1 &
  server=$!
  for _ in {1..100}; do
    url=$(sed -n 's|^listening on \(http://[^ ]*\).*|\1|p' "$log")
    [[ ! $url ]] || return 0
    kill -0 "$server" 2>/dev/null || break
    sleep 0.1
  done
  die "the server did not start: $(cat "$log")"
}

play() {  # COMMAND...: plays in a window, while the command `page` runs
  # In a group of its own, which ends as a whole: CMake, when it is ended, leaves Ninja running.
  setsid nice "${page[@]}" &
  background+=(-$!)
  attended "$@"
}

has_display() { [[ ${DISPLAY:-}${WAYLAND_DISPLAY:-} ]]; }
