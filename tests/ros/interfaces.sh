#!/bin/sh
# Adds message types to .cache/ros that the wheels lack, and that ROS's own packages have: `sh interfaces.sh PACKAGE
# DEPENDENCY...` builds the definitions in interfaces/PACKAGE. It needs a C++ compiler and Python's headers.
set -eu
cd "$(dirname "$0")"
ros=$(cd ../../.cache/ros && pwd)
package=$1
shift
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$ros/bin/pip" install --quiet --target "$work/tools" 'empy<4' lark
AMENT_PREFIX_PATH=$ros PYTHONPATH=$work/tools "$ros/bin/python" interfaces/generate.py "$ros" "interfaces/$package" "$work"
lib=$ros/lib
site=$("$ros/bin/python" -c 'import sysconfig; print(sysconfig.get_path("platlib"))')
mkdir -p "$work/include" "$site/$package"
cp -r "$work/c" "$work/include/$package"
cp -r "$work/fastrtps_c/." "$work/introspection_c/." "$work/include/$package"
headers="-I$work/include -I$ros/include $(printf -- '-I%s ' "$ros"/include/*/)"
headers="$headers $("$ros/bin/python" -c 'import numpy, sysconfig; print("-I" + sysconfig.get_path("include"), "-I" + numpy.get_include())')"

build() { # build KIND LIBRARIES FILES...: a library of this kind, linked to the dependencies' libraries of this kind
  kind=$1 linked=$2
  shift 2
  for each in $dependencies; do linked="$linked -l${each}__$kind"; done
  # shellcheck disable=SC2086 # these are several words
  $compiler -O1 -fPIC -shared -w -DNDEBUG $headers "$@" "-L$lib" \
    "-Wl,--no-as-needed,-rpath,\$ORIGIN,-rpath,\$ORIGIN/../../.." $linked -o "$target"
}
dependencies=$*
compiler=gcc target=$lib/lib${package}__rosidl_generator_c.so
# shellcheck disable=SC2046 # no name of a generated file has a space
build rosidl_generator_c "" $(find "$work/c" -name '*.c')
compiler=g++ target=$lib/lib${package}__rosidl_typesupport_fastrtps_c.so
# shellcheck disable=SC2046
build rosidl_typesupport_fastrtps_c "-l${package}__rosidl_generator_c" $(find "$work/fastrtps_c" -name '*.cpp')
compiler=gcc target=$lib/lib${package}__rosidl_typesupport_introspection_c.so
# shellcheck disable=SC2046
build rosidl_typesupport_introspection_c "-l${package}__rosidl_generator_c" $(find "$work/introspection_c" -name '*.c')
compiler=g++ target=$lib/lib${package}__rosidl_typesupport_c.so
# shellcheck disable=SC2046
build rosidl_typesupport_c -lrosidl_typesupport_c $(find "$work/c" -name '*.cpp')
compiler=gcc target=$lib/lib${package}__rosidl_generator_py.so
# shellcheck disable=SC2046
build rosidl_generator_py "-l${package}__rosidl_generator_c" $(find "$work/py" -name '*_s.c')
for support in typesupport_c typesupport_fastrtps_c; do
  target=$site/$package/${package}_s__rosidl_$support.so
  dependencies=""
  build "" "-l${package}__rosidl_generator_py -l${package}__rosidl_$support -l${package}__rosidl_generator_c" \
    "$work/py/_${package}_s.ep.rosidl_$support.c"
done
cp -r "$work/py/." "$site/$package"
find "$site/$package" -name '*.c' -delete
touch "$site/$package/__init__.py"
"$ros/bin/python" -c "import $package"
