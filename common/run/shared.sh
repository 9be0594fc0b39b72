# What the scripts of ./run share. They source it, and are then in the root of the repository.
set -euo pipefail
from=$PWD
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

die() { printf 'run: %s\n' "$*" >&2; exit 1; }

step=0 steps=1  # each script sets `steps`
say() { printf '\n== Step %d of %d: %s\n' $((++step)) "$steps" "$*"; }

# Processes that end with the script: what runs beside it, and then the server that it talks to.
server='' job='' background=()

end() {  # PID: asks the process, or the group -PID, to end, and kills it after five seconds
  [[ $1 ]] && kill -TERM "$1" 2>/dev/null || return 0
  for _ in {1..50}; do kill -0 "$1" 2>/dev/null || break; sleep 0.1; done
  kill -KILL "$1" 2>/dev/null || true
  wait "$1" 2>/dev/null || true
}

clean_up() {
  trap '' INT TERM HUP
  local pid
  for pid in "$job" "${background[@]}" "$server"; do end "$pid"; done
}
trap clean_up EXIT
trap 'exit 130' INT
trap 'exit 143' TERM HUP

attended() {  # COMMAND...: runs it so that a signal to this script ends it at once
  "$@" & job=$!
  local code=0
  wait "$job" || code=$?
  job=''
  return "$code"
}
