# What `demo` and `telepresence` share: they build the programs, serve on loopback and play.
. "$(dirname "${BASH_SOURCE[0]}")/shared.sh"
bin=build/bin out=build/demo url=''

build_programs() {
  say "install missing packages"
  common/run/install programs
  say "build the programs"
  attended common/run/compile programs
}

make_sequence() {  # NAME [OPTION...]: into $out/NAME, unless it is there
  if [[ $out/$1 -nt $bin/pointreel-synth ]]; then
    echo "It is there already: $out/$1"
  else
    attended $bin/pointreel-synth "$1" -o "$out/$1" --force "${@:2}"
  fi
}

serve() {  # ARGUMENTS...: starts the server and sets `server` and `url`
  : >$out/server.log
  $bin/pointreel-server serve "$@" --listen 127.0.0.1:0 >$out/server.log 2>&1 &
  server=$!
  for _ in {1..100}; do
    url=$(sed -n 's|^listening on \(http://[^ ]*\).*|\1|p' $out/server.log)
    [[ ! $url ]] || return 0
    kill -0 "$server" 2>/dev/null || break
    sleep 0.1
  done
  die "the server did not start: $(cat $out/server.log)"
}

has_display() { [[ ${DISPLAY:-}${WAYLAND_DISPLAY:-} ]]; }

page_picture() {  # FILE URL
  if node client/web/screenshot.mjs "$1" "$2"; then echo "The page in a browser: $1"; fi
}
