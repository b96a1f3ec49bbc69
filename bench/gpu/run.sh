#!/usr/bin/env bash
# Checks and times everything that needs a GPU, in calls of ten minutes: see README.md beside this.
#     bench/gpu/run.sh OUT          kernels, timings, a scene; again until all is done
#     bench/gpu/run.sh OUT paper    cells of the paper's tables at full size; again until all are there
#     bench/gpu/run.sh OUT load     only takes in what was brought
set -u
out=${1:?usage: bench/gpu/run.sh OUT [checks|paper|load] (OUT is a folder for the results)}
agenda=${2:-checks}
case $agenda in
  checks | paper | load) ;;
  *) echo "there are checks, paper and load, and no agenda $agenda" >&2; exit 2 ;;
esac
mkdir -p "$out" && out=$(cd "$out" && pwd) || exit 1
cd "$(dirname "$0")/../.." || exit 1
python=${PYTHON:-python3}
budget=${SECONDS_IN_ALL:-540} # after which nothing is begun; packing takes up to a minute more
brought=${BROUGHT:-runs/brought} # by this call
kept=${KEPT:-runs/kept}          # of all calls
work=${RUNS:-runs/$agenda}       # where everything is made; OUT gets a few small files of it
mkdir -p "$kept" "$work/logs" && kept=$(cd "$kept" && pwd) && work=$(cd "$work" && pwd) || exit 1
export MOBILEGS_CACHE=${MOBILEGS_CACHE:-$kept/cache}
export TORCH_EXTENSIONS_DIR=$kept/extensions MAX_JOBS=${MAX_JOBS:-$(nproc)} PYTHONUNBUFFERED=1
parts=$work/logs/parts.txt
failed=0

# what calls brought adds up: data/CAPTURE, wheels/*.whl, debs/*.deb, parcel/parcel-*.bin
if [ -d "$brought" ]; then
  if [ -d "$brought/parcel" ]; then rm -rf "$kept/parcel"; fi
  cp -r "$brought/." "$kept/" || exit 1
fi
if [ -d "$kept/wheels" ] && { [ ! -f "$kept/installed" ] ||
  [ -n "$(find "$kept/wheels" -newer "$kept/installed")" ]; }; then
  "$python" -m pip install -q --no-index --no-deps --no-compile --no-cache-dir --upgrade \
    --target "$kept/site" "$kept"/wheels/*.whl && touch "$kept/installed" || exit 1
fi
export PYTHONPATH="$PWD:$kept/site${PYTHONPATH:+:$PYTHONPATH}"
if compgen -G "$kept/debs/*.deb" >/dev/null; then # libraries of the system
  for deb in "$kept"/debs/*.deb; do dpkg -x "$deb" "$kept/system" || exit 1; done
  export LD_LIBRARY_PATH="$kept/system/usr/lib/x86_64-linux-gnu${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
fi
icd=/usr/local/nvidia/share/vulkan/icd.d/nvidia_icd.json # where containers may have the driver
if [ -f $icd ]; then export VK_DRIVER_FILES=${VK_DRIVER_FILES:-$icd}; fi
if [ -d "$kept/data" ]; then export MOBILEGS_DATA=${MOBILEGS_DATA:-$kept/data}; fi
du -sh "$kept"/* 2>/dev/null
if [ "$agenda" = load ]; then exit 0; fi
"$python" bench/gpu/ready.py || exit 1
if [ -d "$kept/parcel" ]; then # what the same agenda made on another machine
  "$python" bench/gpu/parcel.py open "$kept/parcel" "$work" || exit 1
  rm -rf "$kept/parcel"
fi

# part NAME SECONDS COMMAND...: runs it for at most so long, keeps its output and its exit code.
# What has succeeded is not repeated; what there is no time for is left to the next call.
has() { grep -qs "^$1 0 " "$parts"; }
part() {
  local name=$1 limit=$2 begun=$SECONDS code left=$((budget - SECONDS))
  shift 2
  limit=$((limit < left ? limit : left))
  if has "$name"; then return; fi
  if [ "$limit" -lt "${SECONDS_AT_LEAST:-20}" ]; then
    echo "== $name: left to the next call"
    failed=1
    return
  fi
  echo "== $name"
  timeout --signal=INT --kill-after=15 "$limit" "$@" 2>&1 | tee "$work/logs/$name.log"
  code=${PIPESTATUS[0]}
  echo "$name $code $((SECONDS - begun))" >>"$parts"
  if [ "$code" -ne 0 ]; then failed=1; fi
}
pack() { "$python" bench/gpu/packed.py "$work" "$out"; }
report() {
  "$python" bench/gpu/collect.py "$work" --json "$out/result.json" || failed=1
  pack
}
gsplat() { [ -f "$kept/gsplat.ready" ]; }

# gsplat compiles itself when it is first used, for minutes. It is given them once a machine, in a
# process of its own, as long as it has anything to time; the lock of one that was interrupted would
# be waited for
build_gsplat() {
  local limit=${SECONDS_OF_GSPLAT:-330}
  if gsplat || [ -f "$work/gsplat.failed" ]; then return; fi
  if has kernels-gsplat && { has frames-gsplat || [ ! -f "$scene/scene.mgs" ]; }; then return; fi
  "$python" -c 'import importlib.util as u; assert u.find_spec("gsplat")' 2>/dev/null || return
  if [ "$limit" -gt $((budget - SECONDS)) ]; then
    echo "== gsplat: left to the next call"
    failed=1
    return
  fi
  rm -f "$kept"/extensions/*/lock
  if timeout --kill-after=15 "$limit" "$python" -c \
    'import sys; from gsplat.cuda._backend import _C; sys.exit(_C is None)' \
    >"$work/logs/gsplat.log" 2>&1; then
    touch "$kept/gsplat.ready"
  else
    echo "it did not compile, or not in time: logs/gsplat.log" >"$work/gsplat.failed"
  fi
  echo "== gsplat: $(ls "$kept/gsplat.ready" "$work/gsplat.failed" 2>/dev/null)"
}

if ! "$python" -c 'from mobilegs.render.kernels.cpu import kernel_level; kernel_level()' 2>/dev/null
then # the kernels of the CPU are what those of the GPU are compared with
  if [ -f "$parts" ]; then sed -i '/^build /d' "$parts"; fi # built elsewhere
  part build 120 bash -c 'cmake -S . -B "$0" -DCMAKE_BUILD_TYPE=Release && cmake --build "$0" -j &&
    cp "$0"/kernels/*.so mobilegs/render/kernels/' "$kept/build"
fi

if [ "$agenda" = paper ]; then
  : >"$parts" # another call may ask for other scenes
  # shellcheck disable=SC2086  # several words
  part paper $((budget - SECONDS - ${SECONDS_OF_FRAMES:-60})) "$python" bench/paper.py \
    --scenes ${SCENES:-full} --rows ${ROWS:-teacher ours codebooks network} --runs "$work" \
    --json "$work/paper.json" --pack "$out"
  for scene in "$work"/*/ours-60000-0/scene.mgs; do
    folder=$(dirname "$scene")
    teacher=$(dirname "$folder")/teacher-mini-splatting-30000-0/teacher.ply
    if [ ! -f "$scene" ] || [ ! -f "$teacher" ]; then continue; fi
    name=$(basename "$(dirname "$folder")")
    case $name in # as bench/paper_places.py has them
      bonsai-800) capture=bonsai ;;
      horns-499) capture=llff_horns ;;
      lego-800) capture=lego ;;
      *) continue ;;
    esac
    frames=("$python" bench/gpu/frames_gpu.py --downscale 1 --capture "${MOBILEGS_DATA:-}/$capture"
      --mgs "$scene" --ply "$teacher" --json "$folder/frames.json")
    if ! grep -qs '"ms"' "$folder/frames.json"; then part "frames-$name" 40 "${frames[@]}"; fi
    if gsplat && ! grep -qs gsplat_ "$folder/frames.json"; then
      part "frames-gsplat-$name" 40 "${frames[@]}" --by gsplat
    fi
  done
  pack
  "$python" bench/gpu/parcel.py pack "$work" "$out"
  exit $failed
fi

scene=$work/scene/bonsai
build_gsplat &
# another torch's warnings are no reason to stop here
part tests 150 "$python" -m pytest -m gpu -q -W default --junitxml="$work/tests.xml" tests/render/test_cuda.py
wait # timings want the processor for themselves
part kernels 90 "$python" bench/gpu/kernels_gpu.py --json "$work/kernels.json"
if gsplat; then
  part kernels-gsplat 60 "$python" bench/gpu/kernels_gpu.py --json "$work/kernels.json" --by gsplat
fi
if [ -d "${MOBILEGS_DATA:-}/bonsai" ]; then
  report
  of_scene=(--mgs "$scene/scene.mgs" --ply "$scene/teacher.ply")
  frames=("$python" bench/gpu/frames_gpu.py --capture "$MOBILEGS_DATA/bonsai" --downscale 2
    "${of_scene[@]}" --json "$work/frames.json")
  part bonsai 300 "$python" -m mobilegs train "$MOBILEGS_DATA/bonsai" -o "$scene" --resume \
    --preset gpu --downscale 2 --steps "${STEPS:-8000}"
  if [ -f "$scene/scene.mgs" ]; then
    part frames 40 "${frames[@]}"
    part native 60 "$python" bench/native.py "${of_scene[@]}" --json "$work/native.json"
    build_gsplat
    if gsplat; then part frames-gsplat 60 "${frames[@]}" --by gsplat; fi
  fi
else
  echo "== bonsai: left out, MOBILEGS_DATA names no folder with it"
fi
report
"$python" bench/gpu/parcel.py pack "$work" "$out"
echo "== $(tr '\n' ';' <"$parts") -> $out/result.json"
exit $failed
