/* SPDX-License-Identifier: Apache-2.0 */
/* Binnacle from C, and from whatever calls C: load a config, push samples, read estimates, take snapshots.
 *
 *     binnacle_composition* composition = NULL;
 *     binnacle_session* session = NULL;
 *     if (binnacle_load("ins.json", NULL, &composition) != BINNACLE_OK) return puts(binnacle_last_error());
 *     binnacle_open(composition, 0, 0, &session);
 *     binnacle_find_channel(session, "imu", &imu);
 *     binnacle_find_block(session, "ins/position", &position);
 *     binnacle_push(session, imu, t0, t, fields, 6);
 *     binnacle_read(session, position, outputs, 3);
 *
 * Every function that can fail returns a status, and never throws. Whatever is refused changes nothing and writes nothing:
 * null pointers, handles that were closed, ids of another kind or another composition, arrays of another size, times beyond
 * BINNACLE_LAST_TIME. Whatever a call gives stands behind its last pointers; none of them may be null.
 *
 * Numbers are in SI; times are nanoseconds; matrices are column-major. Texts are UTF-8. A name or unit that a call gives lives
 * as long as the composition or a session of it; any other text as its function says.
 *
 * binnacle_push(), binnacle_push_sample(), binnacle_add(), binnacle_commit() and the functions binnacle_read_…() neither
 * allocate nor search, unless they fail.
 *
 * Threads: a composition may be used by several at a time, a session by one at a time. The last error is each thread's own. */
#ifndef BINNACLE_H
#define BINNACLE_H

#include <stdint.h>

#if defined(BINNACLE_BUILDS_C) && defined(__GNUC__)
#define BINNACLE_API __attribute__((visibility("default")))
#else
#define BINNACLE_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ---- version */

/* MAJOR changes with what breaks callers, as does the library's soname; MINOR with every addition. */
#define BINNACLE_INTERFACE_MAJOR 1
#define BINNACLE_INTERFACE_MINOR 0

/* Of the library that is loaded: MAJOR << 16 | MINOR. It serves a caller of the same MAJOR and the same or a lower MINOR. */
BINNACLE_API uint32_t binnacle_interface_version(void);
/* Binnacle's own, "0.2.0". */
BINNACLE_API const char* binnacle_version(void);

/* ---- status and errors */

/* The exit statuses of the command, and one more. */
typedef int32_t binnacle_status;
#define BINNACLE_OK 0
#define BINNACLE_FAILED 1   /* a filter's plugin failed */
#define BINNACLE_USAGE 2    /* wrong argument: null pointer, closed handle, unknown name, id, size, time */
#define BINNACLE_CONFIG 3   /* the config is wrong, or a snapshot is not of this composition */
#define BINNACLE_LOAD 4     /* a plugin cannot be loaded */
#define BINNACLE_DATA 5     /* a data file is missing or unusable */
#define BINNACLE_INTERNAL 6 /* anything else: no memory, an error of Binnacle's own */

/* Why the newest call of this thread that failed did so: a line for each error, with file, line and JSON pointer where there
 * are any. "" while none failed; a call that succeeds leaves it. Valid until the thread's next call that fails. */
BINNACLE_API const char* binnacle_last_error(void);
/* The same as a JSON array of objects: severity, code, file, line, column, pointer, message, text. */
BINNACLE_API const char* binnacle_last_error_json(void);

/* ---- compositions: configs, checked and ready to run any number of times */

/* A checked config, ready to run: of binnacle_load() or binnacle_parse(), until binnacle_release(). */
typedef struct binnacle_composition binnacle_composition;

/* A struct that begins with its size may grow: set `size` to sizeof, and what follows to zero. */
typedef struct binnacle_load_options {
  uint64_t size;
  const char* const* vars; /* "NAME=VALUE" each, as `--var` of the command takes them */
  uint64_t var_count;
  const char* const* sets; /* "/JSON/POINTER=VALUE" each, as `--set` takes them */
  uint64_t set_count;
} binnacle_load_options;

/* Any config that `binnacle run` takes. options: null where there are none. Plugins are those of BINNACLE_PLUGIN_PATH, of the
 * config's "plugins", and of the folder lib/binnacle beside this library's or the program's folder. */
BINNACLE_API binnacle_status binnacle_load(const char* path, const binnacle_load_options* options,
                                           binnacle_composition** composition);
/* The same from text. Messages call it `name`, and relative paths start at the folder of `name`. */
BINNACLE_API binnacle_status binnacle_parse(const char* text, const char* name, const binnacle_load_options* options,
                                            binnacle_composition** composition);
/* What is suspicious but no error: a line each; "" where there is nothing. Valid until the composition is released. */
BINNACLE_API binnacle_status binnacle_warnings(const binnacle_composition* composition, const char** text);
/* The same as JSON, as binnacle_last_error_json(). */
BINNACLE_API binnacle_status binnacle_warnings_json(const binnacle_composition* composition, const char** json);
/* Its sessions stay. Null does nothing. */
BINNACLE_API binnacle_status binnacle_release(binnacle_composition* composition);

/* ---- what there is in a composition */

/* Stands for a channel, filter, block or measurement of one composition, in all of its sessions. 0 is none. Another load of
 * the same config gives other ids. */
typedef uint64_t binnacle_id;

/* What binnacle_describe_filter() gives. */
typedef struct binnacle_filter_info {
  uint64_t size;
  const char* name;
  uint64_t blocks;
  uint64_t measurements;
  uint64_t state_size; /* doubles of binnacle_read_state() */
  uint64_t rows;       /* of its covariance P, which is rows × rows */
  binnacle_id input;   /* channel of its driving input; 0: it has none */
} binnacle_filter_info;

/* What binnacle_describe_block() gives. */
typedef struct binnacle_block_info {
  uint64_t size;
  const char* name;
  const char* type;
  uint64_t outputs;
  uint64_t state_offset; /* of its stored value in binnacle_read_state() */
  uint64_t state_size;
  uint64_t first_row; /* in P of the filter */
  uint64_t rows;      /* of its part of P: its estimated and considered error components */
} binnacle_block_info;

/* What binnacle_describe_measurement() gives. */
typedef struct binnacle_measurement_info {
  uint64_t size;
  const char* name;
  binnacle_id channel;
  uint64_t max_rows;
} binnacle_measurement_info;

/* What binnacle_describe_channel() gives. */
typedef struct binnacle_channel_info {
  uint64_t size;
  const char* name;
  uint64_t fields;     /* per epoch */
  uint64_t row_fields; /* per row */
  uint64_t max_rows;
  uint64_t covariance_rows; /* of an attached covariance; 0: samples have none */
} binnacle_channel_info;

/* How a field relates to time. */
typedef int32_t binnacle_kind;
#define BINNACLE_LEVEL 0     /* at an instant */
#define BINNACLE_RATE 1      /* mean over the sample's interval */
#define BINNACLE_INCREMENT 2 /* integral over it */

BINNACLE_API binnacle_status binnacle_channel_count(const binnacle_composition* composition, uint64_t* count);
BINNACLE_API binnacle_status binnacle_filter_count(const binnacle_composition* composition, uint64_t* count);

/* By place, from 0: channels and filters of the composition, blocks and measurements of a filter. */
BINNACLE_API binnacle_status binnacle_channel_at(const binnacle_composition* composition, uint64_t index,
                                                 binnacle_id* channel);
BINNACLE_API binnacle_status binnacle_filter_at(const binnacle_composition* composition, uint64_t index,
                                                binnacle_id* filter);
BINNACLE_API binnacle_status binnacle_block_at(const binnacle_composition* composition, binnacle_id filter,
                                               uint64_t index, binnacle_id* block);
BINNACLE_API binnacle_status binnacle_measurement_at(const binnacle_composition* composition, binnacle_id filter,
                                                     uint64_t index, binnacle_id* measurement);

/* info->size is set by the caller; what is larger than this library knows is filled with zeros. */
BINNACLE_API binnacle_status binnacle_describe_channel(const binnacle_composition* composition, binnacle_id channel,
                                                       binnacle_channel_info* info);
BINNACLE_API binnacle_status binnacle_describe_filter(const binnacle_composition* composition, binnacle_id filter,
                                                      binnacle_filter_info* info);
BINNACLE_API binnacle_status binnacle_describe_block(const binnacle_composition* composition, binnacle_id block,
                                                     binnacle_block_info* info);
BINNACLE_API binnacle_status binnacle_describe_measurement(const binnacle_composition* composition,
                                                           binnacle_id measurement, binnacle_measurement_info* info);

/* Names and units: of a channel's fields per epoch and per row, in the order in which they are pushed; of the rows of its
 * attached covariance; of a block's outputs, in the order in which they are read; of the rows of its part of P. */
BINNACLE_API binnacle_status binnacle_field(const binnacle_composition* composition, binnacle_id channel,
                                            uint64_t index, const char** name, const char** unit, binnacle_kind* kind);
BINNACLE_API binnacle_status binnacle_row_field(const binnacle_composition* composition, binnacle_id channel,
                                                uint64_t index, const char** name, const char** unit,
                                                binnacle_kind* kind);
BINNACLE_API binnacle_status binnacle_covariance_row(const binnacle_composition* composition, binnacle_id channel,
                                                     uint64_t index, const char** name, const char** unit);
BINNACLE_API binnacle_status binnacle_output(const binnacle_composition* composition, binnacle_id block, uint64_t index,
                                             const char** name, const char** unit);
BINNACLE_API binnacle_status binnacle_row(const binnacle_composition* composition, binnacle_id block, uint64_t index,
                                          const char** name, const char** unit);

/* ---- sessions: a composition that runs. Its filters and transforms run; its sources, sinks, smoothers and scores do not:
 * samples are pushed, on any channel */

/* A composition that runs: of binnacle_open(), until binnacle_close(). */
typedef struct binnacle_session binnacle_session;

/* As after binnacle_reset(session, seed, run). */
BINNACLE_API binnacle_status binnacle_open(const binnacle_composition* composition, uint64_t seed, int32_t run,
                                           binnacle_session** session);
/* Null does nothing. */
BINNACLE_API binnacle_status binnacle_close(binnacle_session* session);
/* Back to before the first sample. */
BINNACLE_API binnacle_status binnacle_reset(binnacle_session* session, uint64_t seed, int32_t run);

/* Ids by name: "imu", "ins", "ins/position", "ins/fix"; block and measurement alone where there is one filter. An unknown name
 * is BINNACLE_USAGE; the error names what was likely meant. */
BINNACLE_API binnacle_status binnacle_find_channel(const binnacle_session* session, const char* name,
                                                   binnacle_id* channel);
BINNACLE_API binnacle_status binnacle_find_filter(const binnacle_session* session, const char* name,
                                                  binnacle_id* filter);
BINNACLE_API binnacle_status binnacle_find_block(const binnacle_session* session, const char* name, binnacle_id* block);
BINNACLE_API binnacle_status binnacle_find_measurement(const binnacle_session* session, const char* name,
                                                       binnacle_id* measurement);

/* ---- in */

#define BINNACLE_NO_TIME INT64_MIN
/* Times lie within ± this, so that differences are exact: 146 years. */
#define BINNACLE_LAST_TIME (INT64_C(1) << 62)

/* A sample of one channel, for binnacle_push_sample() and binnacle_add(). */
typedef struct binnacle_sample {
  uint64_t size;
  int64_t t0; /* start of the interval, before t; BINNACLE_NO_TIME: an instant */
  int64_t t;
  const double* fields; /* per epoch, as many as the channel has */
  uint64_t field_count;
  const double* row_fields; /* rows × row fields, row after row */
  uint64_t row_field_count; /* of all rows; a multiple of the channel's row_fields, at most max_rows of them */
  const double* covariance; /* covariance_rows²; null: none */
  uint64_t covariance_count;
} binnacle_sample;

/* A sample of fields per epoch: an instant of its own. Samples of a channel come in order of time. */
BINNACLE_API binnacle_status binnacle_push(binnacle_session* session, binnacle_id channel, int64_t t0, int64_t t,
                                           const double* fields, uint64_t count);
/* The same with rows or a covariance. */
BINNACLE_API binnacle_status binnacle_push_sample(binnacle_session* session, binnacle_id channel,
                                                  const binnacle_sample* sample);
/* Several samples of one instant t, at most one per channel: add each, then commit. */
BINNACLE_API binnacle_status binnacle_add(binnacle_session* session, binnacle_id channel,
                                          const binnacle_sample* sample);
BINNACLE_API binnacle_status binnacle_commit(binnacle_session* session, int64_t t);

/* ---- out. `count` is the length of the array, which must be what there is to read */

/* The block's outputs (roll, pitch, yaw); NaN before the filter has started. */
BINNACLE_API binnacle_status binnacle_read(const binnacle_session* session, binnacle_id block, double* outputs,
                                           uint64_t count);
/* Standard deviations of those outputs, to first order; NaN before the start. */
BINNACLE_API binnacle_status binnacle_read_sigma(const binnacle_session* session, binnacle_id block, double* sigmas,
                                                 uint64_t count);
/* The block's part of P: rows². */
BINNACLE_API binnacle_status binnacle_read_block_covariance(const binnacle_session* session, binnacle_id block,
                                                            double* P, uint64_t count);
/* The whole P of a filter: rows². */
BINNACLE_API binnacle_status binnacle_read_covariance(const binnacle_session* session, binnacle_id filter, double* P,
                                                      uint64_t count);
/* The filter's stored state, laid out as binnacle_block_info gives it. */
BINNACLE_API binnacle_status binnacle_read_state(const binnacle_session* session, binnacle_id filter, double* state,
                                                 uint64_t count);
/* Of the estimates, and of the start; BINNACLE_NO_TIME before it. */
BINNACLE_API binnacle_status binnacle_read_time(const binnacle_session* session, binnacle_id filter, int64_t* t);
BINNACLE_API binnacle_status binnacle_read_start_time(const binnacle_session* session, binnacle_id filter, int64_t* t);
/* 1 or 0. A filter that is not healthy is broken and takes no more samples; pushing is no error then. */
BINNACLE_API binnacle_status binnacle_read_started(const binnacle_session* session, binnacle_id filter, int32_t* is_so);
BINNACLE_API binnacle_status binnacle_read_healthy(const binnacle_session* session, binnacle_id filter, int32_t* is_so);

/* Whether a filter's estimates hold. */
typedef int32_t binnacle_verdict;
#define BINNACLE_VERDICT_OK 0
#define BINNACLE_VERDICT_DOUBTFUL 1
#define BINNACLE_VERDICT_LOST 2

/* Whether the estimates hold so far, by the filter's "trust". */
BINNACLE_API binnacle_status binnacle_read_verdict(const binnacle_session* session, binnacle_id filter,
                                                   binnacle_verdict* verdict);
/* "ok", "doubtful", "lost"; null for any other number. */
BINNACLE_API const char* binnacle_verdict_name(binnacle_verdict verdict);

/* Texts about a filter, each valid until the next of these calls with this session. They allocate.
 * Why it is broken; "" while it is healthy. */
BINNACLE_API binnacle_status binnacle_diagnosis(binnacle_session* session, binnacle_id filter, const char** text);
/* Why its verdict is not ok: a line for each reason; "" where there is none. */
BINNACLE_API binnacle_status binnacle_reasons(binnacle_session* session, binnacle_id filter, const char** text);
/* The same as JSON, as binnacle_last_error_json(). */
BINNACLE_API binnacle_status binnacle_reasons_json(binnacle_session* session, binnacle_id filter, const char** json);
/* Why the newest sample of a measurement that was not accepted was not; "" where there is none. */
BINNACLE_API binnacle_status binnacle_last_reason(binnacle_session* session, binnacle_id measurement,
                                                  const char** text);

/* What became of a measurement's samples. */
typedef struct binnacle_counts {
  uint64_t size;
  int64_t offered;
  int64_t accepted;
  int64_t gated;
  int64_t late;
  int64_t unsupported;
  int64_t invalid;
  int64_t withheld;
  int64_t rejected;
  int64_t before_start; /* came before the filter had started */
  int64_t recoveries;
  int64_t rows_used;     /* of accepted samples */
  int64_t rows_left_out; /* of accepted samples, by a gate by row or key */
  double nis_mean;       /* of accepted samples; NaN where there is none */
  double dof_mean;       /* rows per accepted sample */
} binnacle_counts;

/* counts->size is set by the caller. It allocates. */
BINNACLE_API binnacle_status binnacle_count_samples(const binnacle_session* session, binnacle_id measurement,
                                                    binnacle_counts* counts);

/* ---- snapshots: all that a session is, as bytes; restored it goes on bit for bit */

BINNACLE_API binnacle_status binnacle_snapshot_size(const binnacle_session* session, uint64_t* bytes);
BINNACLE_API binnacle_status binnacle_snapshot(const binnacle_session* session, void* into, uint64_t bytes);
/* Into a session of the same config, plugins and version; any other is BINNACLE_CONFIG. What a snapshot holds is not
 * checked: give it back as it was taken. */
BINNACLE_API binnacle_status binnacle_restore(binnacle_session* session, const void* from, uint64_t bytes);

#ifdef __cplusplus
}
#endif

#endif
