# SPDX-License-Identifier: Apache-2.0
# First file: the project's headers, one a line. Second: "path:line:#include …". Prints those that go the wrong way.

function normal(path,    part, n, i, out, depth) {
  n = split(path, part, "/")
  depth = 0
  for (i = 1; i <= n; ++i) {
    if (part[i] == "" || part[i] == ".") continue
    if (part[i] == ".." && depth > 0) --depth
    else out[++depth] = part[i]
  }
  path = out[1]
  for (i = 2; i <= depth; ++i) path = path "/" out[i]
  return path
}

function folder(path) {
  sub(/\/[^\/]*$/, "", path)
  return path
}

function under(path, prefix) { return index(path, prefix) == 1 }

# The folder of the plugin (or of the shared library) that a path is in: "plugins/core/".
function plugin_of(path,    part) {
  split(path, part, "/")
  return "plugins/" part[2] "/"
}

# The place of a folder of kernel/src in their order; 0 elsewhere.
function order_of(path,    part) {
  split(path, part, "/")
  return part[1] == "kernel" && part[2] == "src" ? index(" base config spec plugin filter compose run ", " " part[3] " ") : 0
}

function may_include(from, to) {
  if (order_of(from) && order_of(to)) return order_of(to) <= order_of(from)
  if (under(from, "kernel/include/")) return under(to, "kernel/include/")
  if (under(from, "kernel/")) return under(to, "kernel/")
  if (under(from, "plugins/"))
    return under(to, "kernel/include/") || under(to, "plugins/common/") || under(to, plugin_of(from))
  # Formats that plugins and the command both write are in shared libraries; a plugin itself is none of sdk's business.
  return under(to, "kernel/include/") || under(to, "sdk/") || under(to, "plugins/common/")
}

# Beyond the project the kernel has Eigen, Boost and nlohmann_json, nothing else.
function foreign_to_kernel(name,    part, n) {
  n = split(name, part, "/")
  return n > 1 && part[1] !~ /^(binnacle|Eigen|unsupported|boost|nlohmann|sys)$/
}

function offence(what) { print where ": " what; }

FNR == NR {
  header[$0] = 1
  next
}

{
  match($0, /^[^:]*:[0-9]+/)
  where = substr($0, 1, RLENGTH)
  from = where
  sub(/:[0-9]+$/, "", from)
  if (!match($0, /["<][^">]+[">]/)) next
  name = substr($0, RSTART + 1, RLENGTH - 2)

  beside = normal(folder(from) "/" name)
  if (beside in header) {
    if (!may_include(from, beside)) offence("includes " beside)
    next
  }
  owner = ""
  for (h in header) {
    if (h != name && substr(h, length(h) - length(name)) != "/" name) continue
    if (may_include(from, h)) next
    owner = h
  }
  if (owner != "") offence("includes " owner)
  else if (under(from, "kernel/") && foreign_to_kernel(name)) offence("the kernel depends on " name)
}
