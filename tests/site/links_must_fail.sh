#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# links.py sees what is not whole: links_must_fail.sh PYTHON
set -euo pipefail
python=$1
here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
. "$here/common.sh"
site=$(mktemp -d)
trap 'rm -rf -- "$site"' EXIT
mkdir -p "$site/api/binnacle"
links() { "$python" "$here/links.py" "$site" binnacle/a.hpp; }

refused "has no page" links
good='<a href="api/binnacle/a.hpp.html#A">A</a><a id="top" href="#top">up</a><a href="https://example.org">far</a>'
echo '<h1 id="A">A</h1>' >"$site/api/binnacle/a.hpp.html"
echo "$good" >"$site/index.html"
links
echo "$good"'<a href="b.html">b</a>' >"$site/index.html"
refused "index.html:1: b.html leads nowhere" links
echo "$good"'<a href="api/binnacle/a.hpp.html#B">b</a>' >"$site/index.html"
refused "a.hpp.html has no such anchor" links
echo "$good"'<a href="#B">b</a>' >"$site/index.html"
refused "index.html has no such anchor" links
echo "$good"'<img src="b.svg">' >"$site/index.html"
refused "b.svg leads nowhere" links
echo "$good"'<link rel="stylesheet" href="https://fonts.example.org/b.css">' >"$site/index.html"
refused "from the network" links
echo "$good"'<code>| a | b |</code><p>| a | b |</p>' >"$site/index.html"
refused "index.html:1: Markdown that was not understood: '| a | b |'" links
echo "$good" >"$site/index.html"
refused "binnacle/b.hpp: no page" "$python" "$here/links.py" "$site" binnacle/b.hpp
