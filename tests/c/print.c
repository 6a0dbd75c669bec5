/* SPDX-License-Identifier: Apache-2.0 */
/* The drive as a program: all that it reads, a number a line, exact. print CONFIG PLUGIN */
#include <stdio.h>

#include "drive.h"

static struct drive_log numbers;

int main(int count, char** arguments) {
  int i;
  if (count != 3) return 2;
  if (drive(arguments[1], arguments[2], &numbers) != 0) return 1;
  for (i = 0; i < numbers.count; ++i) printf("%a\n", numbers.numbers[i]);
  return 0;
}
