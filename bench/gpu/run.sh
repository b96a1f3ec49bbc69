#!/usr/bin/env bash
# Checks and times everything that needs a GPU, in under ten minutes: see README.md beside this.
#     bench/gpu/run.sh OUT          kernels, timings, a scene
#     bench/gpu/run.sh OUT paper    cells of the paper's tables at full size; again until all are there
set -u
out=${1:?usage: bench/gpu/run.sh OUT [paper] (OUT is a folder for the results)}
agenda=${2:-checks}
mkdir -p "$out" && out=$(cd "$out" && pwd) || exit 1
cd "$(dirname "$0")/../.." || exit 1
python=${PYTHON:-python3}
export PYTHONPATH="$PWD${PYTHONPATH:+:$PYTHONPATH}"
# everything is made here; OUT gets a few small files of it
work=${RUNS:-runs/$agenda}
mkdir -p "$work/logs" && work=$(cd "$work" && pwd) || exit 1
export MOBILEGS_CACHE=${MOBILEGS_CACHE:-$work/cache}

if ! "$python" -c 'import sys, torch; sys.exit(not torch.cuda.is_available())'; then
  echo "this machine offers $python no CUDA device (PYTHON=... names another Python)" >&2
  exit 1
fi
: >"$work/logs/parts.txt"
failed=0

# part NAME SECONDS COMMAND...: runs it for at most so long, keeps its output and its exit code
part() {
  local name=$1 limit=$2 begun=$SECONDS code
  shift 2
  echo "== $name"
  timeout --signal=INT --kill-after=15 "$limit" "$@" 2>&1 | tee "$work/logs/$name.log"
  code=${PIPESTATUS[0]}
  echo "$name $code $((SECONDS - begun))" >>"$work/logs/parts.txt"
  if [ "$code" -ne 0 ]; then failed=1; fi
}
pack() { "$python" bench/gpu/packed.py "$work" "$out"; }

if [ "$agenda" = paper ]; then
  # shellcheck disable=SC2086  # several words
  part paper "${SECONDS_OF_PAPER:-510}" "$python" bench/paper.py --scenes ${SCENES:-full} \
    --rows ${ROWS:-teacher ours codebooks network} --runs "$work" --json "$work/paper.json" --pack "$out"
  for scene in "$work"/*/ours-60000-0/scene.mgs; do
    [ -f "$scene" ] || continue
    folder=$(dirname "$scene")
    teacher=$(dirname "$folder")/teacher-mini-splatting-30000-0/teacher.ply
    if [ -f "$folder/frames.json" ] || [ ! -f "$teacher" ]; then continue; fi
    name=$(basename "$(dirname "$folder")")
    case $name in # as bench/paper_places.py has them
      bonsai-800) capture=bonsai ;;
      horns-499) capture=llff_horns ;;
      lego-800) capture=lego ;;
      *) continue ;;
    esac
    if [ $SECONDS -gt 535 ]; then break; fi # the next call times the others
    part "frames-$name" 30 "$python" bench/gpu/frames_gpu.py --downscale 1 \
      --capture "$MOBILEGS_DATA/$capture" --mgs "$scene" --ply "$teacher" \
      --json "$folder/frames.json"
  done
  pack
  exit $failed
fi

# another torch's warnings are no reason to stop here
part tests 150 "$python" -m pytest -m gpu -q -W default --junitxml="$work/tests.xml" tests/test_cuda.py
part kernels 90 "$python" bench/gpu/kernels_gpu.py --json "$work/kernels.json"
if [ -d "${MOBILEGS_DATA:-}/bonsai" ]; then
  scene=$work/scene/bonsai
  pack
  part bonsai 200 "$python" -m mobilegs train "$MOBILEGS_DATA/bonsai" -o "$scene" --resume \
    --preset gpu --downscale 2 --steps "${STEPS:-8000}"
  part frames 30 "$python" bench/gpu/frames_gpu.py --capture "$MOBILEGS_DATA/bonsai" --downscale 2 \
    --mgs "$scene/scene.mgs" --ply "$scene/teacher.ply" --json "$work/frames.json"
  part native 40 "$python" bench/native.py --mgs "$scene/scene.mgs" \
    --ply "$scene/teacher.ply" --json "$work/native.json"
else
  echo "== bonsai: left out, MOBILEGS_DATA names no folder with it"
fi
"$python" bench/gpu/collect.py "$work" --json "$out/result.json" || failed=1
pack
echo "== $(tr '\n' ';' <"$work/logs/parts.txt") -> $out/result.json"
exit $failed
