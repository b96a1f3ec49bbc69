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
export MOBILEGS_CACHE=${MOBILEGS_CACHE:-$out/cache}

if ! "$python" -c 'import sys, torch; sys.exit(not torch.cuda.is_available())'; then
  echo "this machine offers $python no CUDA device (PYTHON=... names another Python)" >&2
  exit 1
fi
: >"$out/parts.txt"
failed=0

# part NAME SECONDS COMMAND...: runs it for at most so long, keeps its output and its exit code
part() {
  local name=$1 limit=$2 begun=$SECONDS code
  shift 2
  echo "== $name"
  timeout --signal=INT --kill-after=20 "$limit" "$@" 2>&1 | tee "$out/$name.log"
  code=${PIPESTATUS[0]}
  echo "$name $code $((SECONDS - begun))" >>"$out/parts.txt"
  if [ "$code" -ne 0 ]; then failed=1; fi
}

if [ "$agenda" = paper ]; then
  # what a call leaves in $RUNS (checkpoints of several hundred MB among it), the next one takes up
  runs=${RUNS:-runs/paper}
  part paper 570 "$python" bench/paper.py --scenes full --rows teacher ours network \
    --runs "$runs" --json "$out/paper.json"
  for scene in "$runs"/*/ours-*-0/scene.mgs; do
    [ -f "$scene" ] || continue
    name=$(basename "$(dirname "$(dirname "$scene")")")
    mkdir -p "$out/$name" && cp "$scene" "$(dirname "$scene")/cell.json" "$out/$name/"
  done
  exit $failed
fi

# another torch's warnings are no reason to stop here
part tests 150 "$python" -m pytest -m gpu -q -W default --junitxml="$out/tests.xml" tests/test_cuda.py
part kernels 100 "$python" bench/gpu/kernels_gpu.py --json "$out/kernels.json"
if [ -d "${MOBILEGS_DATA:-}/bonsai" ]; then
  part bonsai 250 "$python" -m mobilegs train "$MOBILEGS_DATA/bonsai" -o "$out/bonsai" \
    --preset gpu --downscale 2 --steps "${STEPS:-8000}"
  part frames 40 "$python" bench/gpu/frames_gpu.py --capture "$MOBILEGS_DATA/bonsai" --downscale 2 \
    --mgs "$out/bonsai/scene.mgs" --ply "$out/bonsai/teacher.ply" --json "$out/frames.json"
  part native 50 "$python" bench/native.py --mgs "$out/bonsai/scene.mgs" \
    --ply "$out/bonsai/teacher.ply" --json "$out/native.json"
else
  echo "== bonsai: left out, MOBILEGS_DATA names no folder with it"
fi
"$python" bench/gpu/collect.py "$out" --json "$out/result.json" || failed=1
echo "== $(cat "$out/parts.txt" | tr '\n' ';') -> $out/result.json"
exit $failed
