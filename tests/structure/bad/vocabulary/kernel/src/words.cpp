// SPDX-License-Identifier: Apache-2.0
// A retelling, an untold sum and a charmed bookshelf are no offence, nor are lever arms, an amendment or two that are hard to
// tell apart.
int a;  // The filter tells its state.  // bad
int b;  // Told what it is.  // bad
int c;  // What it has to say.  // bad
int d;  // How to mend it.  // bad
int e;  // Nobody hears it.  // bad
int f;  // It is recorded on tape.  // bad
int arm;  // bad
int g;  // A circle of dependencies.  // bad
int h;  // It is too sure.  // bad
int i;  // The crew musters.  // bad
int j;  // An animal of the zoo.  // bad
int lever_arm;
