/* SPDX-License-Identifier: Apache-2.0 */
/* A drive of 20 s of drive.json, pushed and read in C. */
#ifndef BINNACLE_TESTS_C_DRIVE_H
#define BINNACLE_TESTS_C_DRIVE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What is pushed at step k, from 1; a step has 10 ms. Small integers times a constant: the same to the bit in any language. */
#define DRIVE_STEPS 2000
#define DRIVE_STEP_NS INT64_C(10000000)
void drive_imu(int k, double imu[6]);
void drive_fix(int k, double fix[3]);
void drive_gps(int k, double gps[6], double covariance[36]);
void drive_rows(int k, double rows[6][4]);

/* Numbers as they are read, one after the other. */
struct drive_log {
  double numbers[8192];
  int count;
};

/* Ids, as drive_channels_of() looks them up. */
struct drive_channels {
  uint64_t imu, gnss, gps, ranges, pulse;
};

/* Each gives 0, or the number of calls that failed, which are printed. */
struct binnacle_composition;
struct binnacle_session;
int drive_channels_of(const struct binnacle_session* session, struct drive_channels* channels);
/* Pushes steps first + 1 to last. */
int drive_push(struct binnacle_session* session, const struct drive_channels* to, int first, int last);
/* The same after looking the channels up. */
int drive_steps(struct binnacle_session* session, int first, int last);
/* All that there is to read of the filters and their blocks. */
int drive_read(const struct binnacle_composition* composition, struct binnacle_session* session, struct drive_log* log);
/* The whole drive, read after each second. plugin: the file of the test's own. */
int drive(const char* config, const char* plugin, struct drive_log* log);
/* Loads it as drive() does. */
int drive_load(const char* config, const char* plugin, struct binnacle_composition** composition);

/* Snapshots: taken in the middle and restored into another session, and into one that went on. */
int drive_restored(const char* config, const char* plugin);
/* What is refused, each with its status and a message. */
int drive_refusals(const char* config, const char* plugin);

#ifdef __cplusplus
}
#endif

#endif
