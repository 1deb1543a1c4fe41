#!/usr/bin/env bash
# The window of the sample live: at the end of a video it stays until a key is pressed. Needs Xvfb and xdotool. The exit
# code is 77 if OpenCV was built without windows.
#
#   live_window.sh COMMAND ...   (the sample and a video of few images)
set -euo pipefail

folder=$(mktemp -d)
trap 'kill $(jobs -p) 2>/dev/null; rm -rf "$folder"' EXIT

Xvfb -displayfd 3 -screen 0 1024x768x24 3>"$folder/display" 2>/dev/null &
for _ in {1..100}; do [[ -s $folder/display ]] || sleep 0.1; done
DISPLAY=:$(<"$folder/display")
export DISPLAY

"$@" >"$folder/output" 2>&1 &
program=$!
for _ in {1..300}; do
    grep -q 'any key closes the window' "$folder/output" && break
    if ! kill -0 $program 2>/dev/null; then
        cat "$folder/output"
        if grep -q 'The function is not implemented. Rebuild the library with Windows' "$folder/output"; then exit 77; fi
        echo "ended before a key was pressed"
        exit 1
    fi
    sleep 0.1
done
sleep 1
kill -0 $program || { echo "did not wait for a key"; exit 1; }

for window in $(xdotool search --name '.*'); do  # by name it does not find every window
    [[ $(xdotool getwindowname "$window") == 'The end of'* ]] || continue
    # Without a window manager nothing else gives the window the focus.
    xdotool windowfocus "$window" key q
done
wait $program
cat "$folder/output"
