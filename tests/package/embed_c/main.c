/* SPDX-License-Identifier: Apache-2.0 */
/* A filter inside a program in C: samples are pushed, the estimate and its sigma are read. */
#include <binnacle.h>
#include <stdio.h>

static int failed(binnacle_status status) {
  fprintf(stderr, "%s\n", binnacle_last_error()); /* every error of the config, a line each */
  return status;
}

static binnacle_status run(const char* config) {
  binnacle_composition* composition = NULL;
  binnacle_session* session = NULL;
  binnacle_id altimeter = 0, height = 0, seen = 0;
  binnacle_counts counts = {0};
  binnacle_status status;
  double estimate[1], sigma[1];
  int second;

  if ((status = binnacle_load(config, NULL, &composition)) != BINNACLE_OK) return status;
  if ((status = binnacle_open(composition, 0, 0, &session)) != BINNACLE_OK) return status;
  binnacle_release(composition); /* the session keeps what it needs */

  /* Names are looked up once, before the loop; the error for a wrong one names what was meant. */
  if ((status = binnacle_find_channel(session, "altimeter", &altimeter)) != BINNACLE_OK) return status;
  if ((status = binnacle_find_block(session, "walk/height", &height)) != BINNACLE_OK) return status;
  if ((status = binnacle_find_measurement(session, "walk/seen", &seen)) != BINNACLE_OK) return status;

  for (second = 0; second <= 10; ++second) {
    const double z = second == 5 ? 50.0 : 2.0; /* m; the sixth is a fault, which the gate keeps out */
    status = binnacle_push(session, altimeter, BINNACLE_NO_TIME, second * INT64_C(1000000000), &z, 1);
    if (status != BINNACLE_OK) return status;
  }

  counts.size = sizeof counts;
  if ((status = binnacle_read(session, height, estimate, 1)) != BINNACLE_OK) return status;
  if ((status = binnacle_read_sigma(session, height, sigma, 1)) != BINNACLE_OK) return status;
  if ((status = binnacle_count_samples(session, seen, &counts)) != BINNACLE_OK) return status;
  printf("height %.2f m, sigma %.3f m, %d of %d accepted\n", estimate[0], sigma[0], (int)counts.accepted,
         (int)counts.offered);
  return binnacle_close(session);
}

int main(int count, char** arguments) {
  binnacle_status status;
  if (count != 2) return 2;
  status = run(arguments[1]);
  return status == BINNACLE_OK ? 0 : failed(status);
}
