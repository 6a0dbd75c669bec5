/* SPDX-License-Identifier: Apache-2.0 */
#include "drive.h"

#include <binnacle.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Counts what does not hold, and prints it. */
static int failures;
static void check(int holds, const char* what, int line) {
  if (holds) return;
  ++failures;
  printf("drive.c:%d: does not hold: %s; the last error is: %s\n", line, what, binnacle_last_error());
}
#define CHECK(condition) check((condition) != 0, #condition, __LINE__)
#define CHECK_OK(call) CHECK((call) == BINNACLE_OK)

void drive_imu(int k, double imu[6]) {
  int i;
  for (i = 0; i < 3; ++i) imu[i] = ((k * (3 + i)) % 11 - 5) * 1e-5;
  for (i = 3; i < 6; ++i) imu[i] = ((k * (2 + i)) % 13 - 6) * 1e-4;
  imu[5] -= 0.0981;
}

void drive_fix(int k, double fix[3]) {
  fix[0] = 0.8377580409572782 + (k % 7 - 3) * 1e-7;
  fix[1] = 0.19198621771937624 + (k % 5 - 2) * 1e-7;
  fix[2] =
      500 + (k % 9 - 4) * 0.5 + (k > 600 && k < 1000 ? 1000 : 0); /* a stretch of outliers, which the gate refuses */
}

void drive_gps(int k, double gps[6], double covariance[36]) {
  int i, j;
  gps[0] = 4197489.243355404 + (k % 7 - 3) * 0.25;
  gps[1] = 815909.2567256712 + (k % 5 - 2) * 0.25;
  gps[2] = 4717247.902528144 + (k % 3 - 1) * 0.25;
  for (i = 3; i < 6; ++i) gps[i] = ((k * i) % 7 - 3) * 0.015625;
  for (i = 0; i < 6; ++i)
    for (j = 0; j < 6; ++j) covariance[6 * j + i] = i == j ? (i < 3 ? 4.0 : 0.0625) : (i < 3 && j < 3 ? 1.0 : 0.0);
}

void drive_rows(int k, double rows[6][4]) {
  int i;
  for (i = 0; i < 6; ++i) {
    rows[i][0] = i + 1;
    rows[i][1] = 5 + ((k * (i + 1)) % 5 - 2) * 0.25 + (i == 3 && k % 300 == 0 ? 500 : 0);
    rows[i][2] = (i - 2) * 0.125;
    rows[i][3] = 1;
  }
}

static binnacle_sample sample_at(int64_t t, const double* fields, uint64_t count) {
  binnacle_sample sample;
  memset(&sample, 0, sizeof sample);
  sample.size = sizeof sample;
  sample.t0 = BINNACLE_NO_TIME;
  sample.t = t;
  sample.fields = fields;
  sample.field_count = count;
  return sample;
}

int drive_channels_of(const binnacle_session* session, struct drive_channels* channels) {
  const int before = failures;
  CHECK_OK(binnacle_find_channel(session, "imu", &channels->imu));
  CHECK_OK(binnacle_find_channel(session, "gnss", &channels->gnss));
  CHECK_OK(binnacle_find_channel(session, "gps", &channels->gps));
  CHECK_OK(binnacle_find_channel(session, "ranges", &channels->ranges));
  CHECK_OK(binnacle_find_channel(session, "pulse", &channels->pulse));
  return failures - before;
}

int drive_steps(binnacle_session* session, int first, int last) {
  struct drive_channels to = {0, 0, 0, 0, 0};
  const int failed = drive_channels_of(session, &to);
  return failed + drive_push(session, &to, first, last);
}

int drive_push(binnacle_session* session, const struct drive_channels* to, int first, int last) {
  const int before = failures;
  int k;
  for (k = first + 1; k <= last; ++k) {
    const int64_t t = k * DRIVE_STEP_NS;
    double w_f[6];
    drive_imu(k, w_f);
    if (k % 20 == 0) { /* two of one instant, which are added and committed */
      double fix[3];
      binnacle_sample sample = sample_at(t, w_f, 6);
      sample.t0 = t - DRIVE_STEP_NS;
      CHECK_OK(binnacle_add(session, to->imu, &sample));
      drive_fix(k, fix);
      sample = sample_at(t, fix, 3);
      CHECK_OK(binnacle_add(session, to->gnss, &sample));
      CHECK_OK(binnacle_commit(session, t));
    } else {
      CHECK_OK(binnacle_push(session, to->imu, t - DRIVE_STEP_NS, t, w_f, 6));
    }
    if (k % 50 == 0) { /* with a covariance, and ahead of the input by 4 ms */
      double z[6], covariance[36];
      binnacle_sample sample = sample_at(t + 4000000, z, 6);
      drive_gps(k, z, covariance);
      sample.covariance = covariance;
      sample.covariance_count = 36;
      CHECK_OK(binnacle_push_sample(session, to->gps, &sample));
    }
    if (k % 30 == 0) { /* with rows */
      double rows[6][4];
      binnacle_sample sample = sample_at(t, NULL, 0);
      drive_rows(k, rows);
      sample.row_fields = &rows[0][0];
      sample.row_field_count = 24;
      CHECK_OK(binnacle_push_sample(session, to->ranges, &sample));
    }
    if (k % 100 == 0) {
      const double z = 0.5;
      CHECK_OK(binnacle_push(session, to->pulse, BINNACLE_NO_TIME, t, &z, 1));
    }
  }
  return failures - before;
}

static double* room(struct drive_log* log, uint64_t count) {
  double* const at = log->numbers + log->count;
  if (log->count + (int)count > (int)(sizeof log->numbers / sizeof log->numbers[0])) {
    printf("drive.c: the log is full\n");
    exit(1);
  }
  log->count += (int)count;
  return at;
}

static void read_filter(const binnacle_composition* composition, binnacle_session* session, binnacle_id filter,
                        struct drive_log* log) {
  binnacle_filter_info about = {sizeof about, NULL, 0, 0, 0, 0, 0};
  int64_t t = 0;
  int32_t is_healthy = -1, is_started = -1;
  binnacle_verdict verdict = -1;
  uint64_t b;
  CHECK_OK(binnacle_describe_filter(composition, filter, &about));
  CHECK_OK(binnacle_read_state(session, filter, room(log, about.state_size), about.state_size));
  CHECK_OK(binnacle_read_covariance(session, filter, room(log, about.rows * about.rows), about.rows * about.rows));
  CHECK_OK(binnacle_read_time(session, filter, &t));
  CHECK_OK(binnacle_read_healthy(session, filter, &is_healthy));
  CHECK_OK(binnacle_read_started(session, filter, &is_started));
  CHECK_OK(binnacle_read_verdict(session, filter, &verdict));
  *room(log, 1) = (double)t;
  *room(log, 1) = is_healthy;
  *room(log, 1) = is_started;
  *room(log, 1) = verdict;
  for (b = 0; b < about.blocks; ++b) {
    binnacle_id block = 0;
    binnacle_block_info of = {sizeof of, NULL, NULL, 0, 0, 0, 0, 0};
    CHECK_OK(binnacle_block_at(composition, filter, b, &block));
    CHECK_OK(binnacle_describe_block(composition, block, &of));
    CHECK_OK(binnacle_read(session, block, room(log, of.outputs), of.outputs));
    CHECK_OK(binnacle_read_sigma(session, block, room(log, of.outputs), of.outputs));
    CHECK_OK(binnacle_read_block_covariance(session, block, room(log, of.rows * of.rows), of.rows * of.rows));
  }
}

int drive_read(const binnacle_composition* composition, binnacle_session* session, struct drive_log* log) {
  const int before = failures;
  uint64_t filters = 0, f;
  CHECK_OK(binnacle_filter_count(composition, &filters));
  for (f = 0; f < filters; ++f) {
    binnacle_id filter = 0;
    CHECK_OK(binnacle_filter_at(composition, f, &filter));
    read_filter(composition, session, filter, log);
  }
  return failures - before;
}

int drive_load(const char* config, const char* plugin, binnacle_composition** composition) {
  const int before = failures;
  char named[1024];
  const char* const vars[] = {"sigma=3 m"};
  const char* sets[] = {"/plugins=[]", NULL};
  binnacle_load_options options = {sizeof options, NULL, 1, NULL, 2};
  options.vars = vars;
  options.sets = sets;
  snprintf(named, sizeof named, "/plugins/-=%s", plugin);
  sets[1] = named;
  CHECK_OK(binnacle_load(config, &options, composition));
  return failures - before;
}

int drive(const char* config, const char* plugin, struct drive_log* log) {
  const int before = failures;
  binnacle_composition* composition = NULL;
  binnacle_session* session = NULL;
  int second;
  drive_load(config, plugin, &composition);
  CHECK_OK(binnacle_open(composition, 3, 4, &session));
  for (second = 0; second < DRIVE_STEPS / 100; ++second) {
    drive_steps(session, 100 * second, 100 * (second + 1));
    drive_read(composition, session, log);
  }
  CHECK_OK(binnacle_release(composition)); /* the session stays */
  drive_steps(session, DRIVE_STEPS, DRIVE_STEPS + 100);
  CHECK_OK(binnacle_close(session));
  return failures - before;
}

static int same(const struct drive_log* a, const struct drive_log* b) {
  return a->count == b->count && memcmp(a->numbers, b->numbers, sizeof(double) * (size_t)a->count) == 0;
}

int drive_restored(const char* config, const char* plugin) {
  const int before = failures;
  static struct drive_log middle, end, again, other, anew;
  binnacle_composition* composition = NULL;
  binnacle_session *one = NULL, *two = NULL;
  uint64_t size = 0;
  void* snapshot;
  middle.count = end.count = again.count = other.count = anew.count = 0;
  drive_load(config, plugin, &composition);
  CHECK_OK(binnacle_open(composition, 0, 0, &one));
  CHECK_OK(binnacle_open(composition, 1, 2, &two));
  CHECK_OK(binnacle_snapshot_size(one, &size));
  CHECK(size > 0);
  snapshot = malloc((size_t)size);
  drive_steps(one, 0, 830); /* while samples wait and outliers are refused */
  CHECK_OK(binnacle_snapshot(one, snapshot, size));
  drive_read(composition, one, &middle);
  drive_steps(one, 830, DRIVE_STEPS);
  drive_read(composition, one, &end);
  CHECK(!same(&middle, &end));

  CHECK_OK(binnacle_restore(two, snapshot, size));
  drive_steps(two, 830, DRIVE_STEPS);
  drive_read(composition, two, &other);
  CHECK(same(&end, &other));
  CHECK_OK(binnacle_restore(one, snapshot, size));
  drive_read(composition, one, &again);
  CHECK(same(&middle, &again));
  CHECK_OK(binnacle_reset(one, 0, 0));
  drive_steps(one, 0, 830);
  drive_read(composition, one, &anew);
  CHECK(same(&middle, &anew));

  memset(snapshot, 7, 16);
  CHECK(binnacle_restore(one, snapshot, size) == BINNACLE_CONFIG);
  CHECK(strstr(binnacle_last_error(), "these bytes are not a snapshot") != NULL);
  CHECK(binnacle_restore(one, snapshot, 3) == BINNACLE_CONFIG);
  CHECK(binnacle_snapshot(one, snapshot, size - 1) == BINNACLE_USAGE);
  again.count = 0;
  drive_read(composition, one, &again); /* refused, and nothing changed */
  CHECK(same(&middle, &again));
  free(snapshot);
  CHECK_OK(binnacle_close(one));
  CHECK_OK(binnacle_close(two));
  CHECK_OK(binnacle_release(composition));
  return failures - before;
}

/* Refused with this status and a message that holds these words. */
static void refused(binnacle_status status, binnacle_status wanted, const char* words, int line) {
  if (status == wanted && strstr(binnacle_last_error(), words)) return;
  ++failures;
  printf("drive.c:%d: status %d (%d is wanted), error: %s (to hold: %s)\n", line, (int)status, (int)wanted,
         binnacle_last_error(), words);
}
#define REFUSED(call, words) refused((call), BINNACLE_USAGE, (words), __LINE__)

static void refused_loads(const char* config) {
  binnacle_composition* composition = NULL;
  const char* const wrong[] = {"sigma"};
  binnacle_load_options options = {sizeof options, NULL, 1, NULL, 0};
  struct {
    binnacle_load_options known;
    uint64_t later;
  } newer;
  REFUSED(binnacle_load(NULL, NULL, &composition), "binnacle_load: path is null");
  REFUSED(binnacle_load(config, NULL, NULL), "composition is null");
  REFUSED(binnacle_parse(NULL, "a.json", NULL, &composition), "text is null");
  REFUSED(binnacle_load(config, &options, &composition), "options->vars is null");
  options.vars = wrong;
  REFUSED(binnacle_load(config, &options, &composition), "NAME=VALUE; found 'sigma'");
  options.size = 8;
  REFUSED(binnacle_load(config, &options, &composition), "options->size is 8");
  memset(&newer, 0, sizeof newer);
  newer.known.size = sizeof newer;
  newer.later = 1;
  REFUSED(binnacle_load(config, &newer.known, &composition), "does not know");
  refused(binnacle_load("nowhere.json", NULL, &composition), BINNACLE_CONFIG, "nowhere.json: error[B003]", __LINE__);
  refused(binnacle_parse("{\"binnacle\": 1,\n \"filter\": {}, \"sources\": 3}", "mine.json", NULL, &composition),
          BINNACLE_CONFIG, "mine.json:2:2: error[B012] /filter", __LINE__);
  CHECK(strstr(binnacle_last_error(), "mine.json:2:27: error[B006] /sources") != NULL); /* all at once */
  CHECK(strstr(binnacle_last_error_json(), "\"pointer\":\"/sources\"") != NULL);
  CHECK(strstr(binnacle_last_error_json(), "\"line\":2,\"column\":2,\"pointer\":\"/filter\"") != NULL);
  refused(binnacle_parse("{\"binnacle\": 1, \"plugins\": [\"none.so\"], \"filters\": {}}", "mine.json", NULL,
                         &composition),
          BINNACLE_LOAD, "error[B040]", __LINE__);
  CHECK(composition == NULL);
}

static void refused_ids(const binnacle_composition* composition, const binnacle_composition* other,
                        binnacle_session* session) {
  binnacle_id imu = 0, ins = 0, foreign = 0, id = 77;
  binnacle_filter_info info = {sizeof info, NULL, 0, 0, 0, 0, 0};
  const char *name, *unit;
  binnacle_kind kind;
  int64_t t = 77;
  double numbers[6] = {0, 0, 0, 0, 0, 0};
  CHECK_OK(binnacle_find_channel(session, "imu", &imu));
  CHECK_OK(binnacle_find_filter(session, "ins", &ins));
  CHECK_OK(binnacle_filter_at(other, 0, &foreign));
  REFUSED(binnacle_find_channel(session, "imo", &id), "there is no channel 'imo'; did you mean 'imu'?");
  REFUSED(binnacle_find_filter(session, "insx", &id), "did you mean 'ins'?");
  REFUSED(binnacle_find_block(session, "ins/positon", &id), "did you mean 'ins/position'?");
  REFUSED(binnacle_find_measurement(session, "ins/fux", &id), "did you mean 'ins/fix'?");
  REFUSED(binnacle_find_channel(session, NULL, &id), "name is null");
  REFUSED(binnacle_find_channel(session, "imu", NULL), "channel is null");
  REFUSED(binnacle_read_time(session, imu, &t), "the id of a filter is wanted; this is that of a channel");
  REFUSED(binnacle_read_time(session, 0, &t), "this is that of nothing");
  REFUSED(binnacle_read_time(session, foreign, &t), "this id of a filter is of another composition");
  REFUSED(binnacle_read_time(session, ins + 3, &t), "there is no filter 3 (of 3)");
  REFUSED(binnacle_push(session, ins, 0, 1, numbers, 6), "the id of a channel is wanted; this is that of a filter");
  REFUSED(binnacle_push(session, imu + 100, 0, 1, numbers, 6), "there is no channel 100");
  REFUSED(binnacle_describe_filter(composition, foreign, &info), "of another composition");
  info.size = 8;
  REFUSED(binnacle_describe_filter(composition, ins, &info), "info->size is 8; set it to sizeof, 56");
  REFUSED(binnacle_describe_filter(composition, ins, NULL), "info is null");
  REFUSED(binnacle_filter_at(composition, 3, &id), "there is no filter 3 (of 3)");
  REFUSED(binnacle_block_at(composition, ins, 5, &id), "there is no block 5 (of 5)");
  REFUSED(binnacle_field(composition, imu, 6, &name, &unit, &kind), "channel 'imu' has no field 6 per epoch (of 6)");
  REFUSED(binnacle_row_field(composition, imu, 0, &name, &unit, &kind), "has no field 0 per row (of 0)");
  CHECK(id == 77 && t == 77); /* nothing was written */
}

static void refused_samples(binnacle_session* session) {
  binnacle_id imu = 0, gps = 0, ranges = 0;
  double numbers[36] = {0};
  binnacle_sample sample = sample_at(1, numbers, 6);
  CHECK_OK(binnacle_find_channel(session, "imu", &imu));
  CHECK_OK(binnacle_find_channel(session, "gps", &gps));
  CHECK_OK(binnacle_find_channel(session, "ranges", &ranges));
  REFUSED(binnacle_push(session, imu, 0, 1, numbers, 5), "channel 'imu' has 6 fields; got 5");
  REFUSED(binnacle_push(session, imu, 0, 1, NULL, 6), "fields is null");
  REFUSED(binnacle_push(session, imu, 2, 2, numbers, 6), "begins at 2 ns and ends at 2 ns");
  REFUSED(binnacle_push(session, imu, 0, INT64_MAX, numbers, 6), "times lie within 2^62 ns");
  REFUSED(binnacle_push(session, imu, 0, BINNACLE_NO_TIME, numbers, 6), "times lie within 2^62 ns");
  REFUSED(binnacle_push_sample(session, imu, NULL), "sample is null");
  sample.size = 0;
  REFUSED(binnacle_push_sample(session, gps, &sample), "sample->size is 0");
  sample.size = sizeof sample;
  sample.covariance = numbers;
  sample.covariance_count = 35;
  REFUSED(binnacle_push_sample(session, gps, &sample), "takes a covariance of 36 numbers, or none");
  sample.covariance = NULL;
  REFUSED(binnacle_push_sample(session, gps, &sample), "takes a covariance of 36 numbers, or none");
  sample.covariance = numbers;
  sample.covariance_count = 0;
  sample.t0 = 0;
  REFUSED(binnacle_push_sample(session, imu, &sample), "takes a covariance of 0 numbers, or none");
  sample = sample_at(1, NULL, 6);
  REFUSED(binnacle_push_sample(session, gps, &sample), "a sample on channel 'gps' has no fields");
  sample = sample_at(1, NULL, 0);
  sample.row_fields = numbers;
  sample.row_field_count = 23;
  REFUSED(binnacle_push_sample(session, ranges, &sample), "up to 8 rows of 4 fields");
  sample.row_field_count = 36;
  REFUSED(binnacle_push_sample(session, ranges, &sample), "up to 8 rows of 4 fields");
  sample = sample_at(5, numbers, 6);
  CHECK_OK(binnacle_add(session, gps, &sample));
  REFUSED(binnacle_commit(session, 6), "commit() takes the time of the samples that were added");
  sample.t = 6;
  REFUSED(binnacle_add(session, gps, &sample), "samples that are added together have one time");
  CHECK_OK(binnacle_commit(session, 5));
}

static void refused_reads(binnacle_session* session) {
  binnacle_id ins = 0, position = 0, fix = 0;
  double numbers[300];
  const char* text = NULL;
  int32_t flag = 77;
  binnacle_counts counts;
  memset(&counts, 0, sizeof counts);
  CHECK_OK(binnacle_find_filter(session, "ins", &ins));
  CHECK_OK(binnacle_find_block(session, "ins/position", &position));
  CHECK_OK(binnacle_find_measurement(session, "ins/fix", &fix));
  numbers[0] = 77;
  REFUSED(binnacle_read(session, position, numbers, 4), "block 'position' has 3 outputs; there is room for 4");
  REFUSED(binnacle_read_sigma(session, position, numbers, 2), "there is room for 2");
  REFUSED(binnacle_read(session, position, NULL, 3), "outputs is null");
  REFUSED(binnacle_read_block_covariance(session, position, numbers, 6), "has 9 numbers; there are 6");
  REFUSED(binnacle_read_block_covariance(session, position, NULL, 9), "P is null");
  REFUSED(binnacle_read_covariance(session, ins, numbers, 225), "this covariance has 196 numbers; there are 225");
  REFUSED(binnacle_read_state(session, ins, numbers, 3), "this state has");
  REFUSED(binnacle_read_healthy(session, ins, NULL), "is_so is null");
  REFUSED(binnacle_diagnosis(session, ins, NULL), "text is null");
  REFUSED(binnacle_diagnosis(session, fix, &text), "the id of a filter is wanted; this is that of a measurement");
  REFUSED(binnacle_count_samples(session, fix, &counts), "counts->size is 0");
  REFUSED(binnacle_snapshot(session, NULL, 100), "into is null");
  REFUSED(binnacle_read_verdict(session, ins, NULL), "verdict is null");
  CHECK(numbers[0] == 77 && flag == 77 && text == NULL);
  CHECK(binnacle_verdict_name(3) == NULL && binnacle_verdict_name(-1) == NULL);
  CHECK(strcmp(binnacle_verdict_name(BINNACLE_VERDICT_LOST), "lost") == 0);
}

int drive_refusals(const char* config, const char* plugin) {
  const int before = failures;
  binnacle_composition *composition = NULL, *other = NULL;
  binnacle_session *session = NULL, *late = NULL;
  int32_t flag = 77;
  double number = 77;
  refused_loads(config);
  drive_load(config, plugin, &composition);
  drive_load(config, plugin, &other);
  REFUSED(binnacle_open(NULL, 0, 0, &session), "composition is null");
  REFUSED(binnacle_open(composition, 0, 0, NULL), "session is null");
  REFUSED(binnacle_open(composition, 0, -1, &session), "runs count from 0");
  CHECK_OK(binnacle_open(composition, 0, 0, &session));
  refused_ids(composition, other, session);
  refused_samples(session);
  refused_reads(session);
  REFUSED(binnacle_read(NULL, 0, &number, 1), "session is null");
  REFUSED(binnacle_commit(NULL, 0), "session is null");
  /* A program in another language may mix them up. */
  REFUSED(binnacle_open((const binnacle_composition*)(const void*)session, 0, 0, &late), "no handle of a composition");
  CHECK_OK(binnacle_close(session));
  REFUSED(binnacle_close(session), "the session was closed before");
  REFUSED(binnacle_read_healthy(session, 0, &flag), "the session was closed");
  CHECK_OK(binnacle_release(other));
  REFUSED(binnacle_release(other), "the composition was closed before");
  REFUSED(binnacle_open(other, 0, 0, &late), "the composition was closed");
  CHECK_OK(binnacle_release(composition));
  CHECK_OK(binnacle_close(NULL));
  CHECK_OK(binnacle_release(NULL));
  CHECK(late == NULL && flag == 77 && number == 77);
  return failures - before;
}
