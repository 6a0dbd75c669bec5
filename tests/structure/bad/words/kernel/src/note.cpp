// SPDX-License-Identifier: Apache-2.0
// Hackney stubborn placeholders are no offence, nor is std::placeholders::_1 nor mktemp -t a.XXXXXX.
int a;  // T@ODO  // bad
int b;  // F@IXME: later  // bad
int c;  // X@XX  // bad
int d;  // a H@ACK  // bad
int e;  // only a S@tub  // bad
int f;  // a p@laceholder  // bad
int g;  // Not i@mplemented  // bad
