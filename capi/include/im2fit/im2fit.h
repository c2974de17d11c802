/* SPDX-License-Identifier: Apache-2.0 */
/*
 * im2fit measures a person in front of one depth camera. All processing runs on this machine.
 *
 *   im2fit_settings settings;
 *   im2fit_settings_init(&settings, sizeof settings);
 *   settings.pack_path = "im2fit-models-1.0.0.i2p";
 *   settings.width = 480; settings.height = 640;               upright pixels
 *   settings.fx = settings.fy = 575.8f; settings.cx = 239.5f; settings.cy = 319.5f;
 *   im2fit_handle* handle;
 *   if (im2fit_open(&settings, &handle) != IM2FIT_OK) puts(im2fit_last_error(NULL));
 *   while (next_frame(depth)) {
 *     im2fit_push(handle, depth, 480, 640, 0, sequence++, time_ns);
 *     im2fit_poll(handle, &result, sizeof result);             show result.guidance to the person
 *     if (result.state == IM2FIT_STATE_MEASURED) break;
 *   }
 *   im2fit_finish(handle);                                     measures with the accepted frames, if sufficient
 *   im2fit_close(handle);
 *
 * Rules for every function:
 *   - Status: 0 is success, errors are negative. im2fit_last_error describes an error in one line.
 *   - Errors: each function lists its own. A function that takes a handle and returns a status can also return
 *     INVALID_ARGUMENT (a pointer that is required is NULL), FORKED, NO_MEMORY and INTERNAL.
 *   - Memory: the caller owns all memory except the handle. The library owns the strings that it returns. They are
 *     constant.
 *   - Text: paths and URIs are UTF-8 and end with a zero byte.
 *   - Enumerations: a field that holds one is an int32_t, so that its size never depends on a compiler. Its comment
 *     names the constants; `im2fit_state` and so on are for your own variables and switches.
 *   - Units: millimetres, kilograms, degrees, unless a name or comment states another unit.
 *   - Camera axes of the upright picture: x right, y down, z forward. Left and right are the person's own.
 *   - Threads: one thread at a time may use a handle. Exception: any thread may call im2fit_poll and im2fit_mask at
 *     any time before im2fit_close. Different handles are independent.
 *   - fork(): a handle belongs to the process that opened it. In a child process every function that returns a status
 *     returns IM2FIT_ERROR_FORKED. im2fit_close works in the child and does not touch the parent's camera and
 *     threads.
 *   - No function throws, prints or ends the program.
 *   - Between im2fit_open and im2fit_close no function allocates, unless the comment of a function or field says so.
 *   - Results: the same files and frames give the same bits on every supported machine (with live = 0).
 *   - ABI: the soname is libim2fit.so.0. Its number is not the major version. It changes, together with a major
 *     version, only when programs built with an older header no longer run.
 *   - Not promised: struct layouts across major versions, guidance on any particular frame, speed.
 */
#ifndef IM2FIT_IM2FIT_H
#define IM2FIT_IM2FIT_H

#include <stddef.h>
#include <stdint.h>

#define IM2FIT_VERSION_MAJOR 1
#define IM2FIT_VERSION_MINOR 0
#define IM2FIT_VERSION_PATCH 0
/* For #if: 10000 is 1.0.0, 10203 is 1.2.3. */
#define IM2FIT_VERSION_NUMBER (IM2FIT_VERSION_MAJOR * 10000 + IM2FIT_VERSION_MINOR * 100 + IM2FIT_VERSION_PATCH)

#if defined(_WIN32)
#define IM2FIT_API
#else
#define IM2FIT_API __attribute__((visibility("default")))
#endif

/* NOLINTBEGIN(readability-identifier-naming): C's names, with the library's prefix */
#ifdef __cplusplus
extern "C" {
#endif

typedef struct im2fit_handle im2fit_handle; /* measures one person at a time, with one camera */

/* ---- Status ---------------------------------------------------------------------------------------------------- */

typedef enum im2fit_status {
  IM2FIT_OK = 0,
  IM2FIT_ERROR_INVALID_ARGUMENT = -1, /* NULL, out of range, wrong size, or not allowed now */
  IM2FIT_ERROR_NOT_FOUND = -2,        /* a file, device node, id or name does not exist */
  IM2FIT_ERROR_IO = -3,               /* the operating system reported an error */
  IM2FIT_ERROR_CORRUPT = -4,          /* a file or frame is damaged, or has another format or version */
  IM2FIT_ERROR_UNSUPPORTED = -5,      /* files were not made together, or this library lacks the feature */
  IM2FIT_ERROR_NO_DEVICE = -6,        /* the camera is not connected, or was unplugged */
  IM2FIT_ERROR_TIMEOUT = -7,          /* no frame in time: call again */
  IM2FIT_ERROR_END_OF_STREAM = -8,    /* the source has no more frames */
  IM2FIT_ERROR_NO_MEMORY = -9,
  IM2FIT_ERROR_NOT_MEASURED = -10, /* there is no measurement yet */
  IM2FIT_ERROR_TOO_SMALL = -11,    /* the buffer is too small; the needed count is written */
  IM2FIT_ERROR_INTERNAL = -12,
  IM2FIT_ERROR_FORKED = -13 /* the parent process opened the handle before fork(): open another in this process */
} im2fit_status;

/* The version of the library in use, "1.0.0". It may be newer than this header. Any thread. */
IM2FIT_API const char* im2fit_version(void);

/* The short name of a status: "no_device". "unknown" for other numbers. Any thread. */
IM2FIT_API const char* im2fit_status_name(int status);

/* The error of the latest call on this handle, as one line of text. "" after a success. The text is valid until the
 * next call on the handle. im2fit_poll and im2fit_mask do not change it, because any thread may call them. FORKED
 * does not change it.
 * With NULL: the latest error of any call on the calling thread, including im2fit_open, im2fit_poll, im2fit_mask and
 * FORKED. A success does not clear it.
 * END_OF_STREAM and TIMEOUT of im2fit_pump and im2fit_wait are not failures: they have no text. */
IM2FIT_API const char* im2fit_last_error(const im2fit_handle* handle);

/* ---- Opening --------------------------------------------------------------------------------------------------- */

/* Called for each failure of a function on the handle, on the thread of that call. Also called when im2fit_open
 * rejects a setting, cannot load a file or cannot start a thread. The text is valid during the call. Not called for
 * im2fit_poll, im2fit_mask and FORKED. */
typedef void (*im2fit_log_fn)(void* user, int status, const char* text);

/* Where a model is stored: in a file with a path, in memory, or in a part of an open file, such as an asset of an
 * APK. */
typedef enum im2fit_data_kind { IM2FIT_DATA_PATH = 0, IM2FIT_DATA_MEMORY = 1, IM2FIT_DATA_FD = 2 } im2fit_data_kind;
typedef struct im2fit_data {
  int32_t kind;   /* IM2FIT_DATA_...; PATH: the setting ..._path names the file, and the fields below are ignored */
  int32_t fd;     /* FD: a seekable file, open for reading. The caller owns it and may close it after im2fit_open */
  int64_t offset; /* FD: bytes before the data. An asset must be stored in the APK, not compressed */
  const void* bytes; /* MEMORY: im2fit_open copies them */
  size_t size;       /* MEMORY, FD: bytes, 1..2^30; copied. PATH: a file larger than 64 MiB is mapped */
} im2fit_data;

typedef struct im2fit_settings {
  size_t struct_size;         /* written by im2fit_settings_init */
  const char* tracker_path;   /* .i2t; required without a pack */
  const char* index_path;     /* .i2f; required without a pack */
  const char* body_path;      /* .i2b. NULL without a pack: no mesh, tape, avatar, garments or fitted shape */
  const char* men_chart_path; /* .csv size charts (docs/result.md); both or neither. NULL: built-in EN 13402-3 */
  const char* women_chart_path;
  int32_t width; /* size of upright frames, pixels, 1..2048 */
  int32_t height;
  float fx, fy, cx, cy;    /* pixels; of the depth camera, not of the colour camera. The centre of pixel 0 is 0 */
  int32_t frames_wanted;   /* 15: accepted frames until MEASURED, 1..1000. With TURN_BACK: for each side */
  int32_t frames_min;      /* 5: fewest accepted frames for im2fit_finish to measure, 1..frames_wanted */
  int32_t calibration_psi; /* 0: off. 1: the person raises the arms first. Flags other than 0 and 1 are refused */
  int32_t live;          /* 0: im2fit_push waits when the engine is behind. 1: it drops and counts the oldest frame */
  int32_t single_thread; /* 0: two threads. 1: im2fit_push does all work itself, and `live` has no effect */
  int32_t pool_frames;   /* 8: frames buffered, 3..64. Each takes three bytes per pixel */
  im2fit_log_fn log;     /* NULL: none. Used until im2fit_close */
  void* log_user;
  int32_t user_id;  /* 0: the first person with empty guidance. Else: the person with this im2fit_result.user_id */
  int32_t turn;     /* IM2FIT_TURN_...: what the person is asked to do after the front is accumulated */
  int32_t clothing; /* IM2FIT_CLOTHING_...: what the person wears. 0: estimated from the frames */
  int32_t sensor;   /* IM2FIT_SENSOR_...: how the camera senses depth. 0: estimated from the frames */
  im2fit_data tracker_data; /* these replace the paths above */
  im2fit_data index_data;
  im2fit_data body_data;
  const char* calibration_site_path; /* .i2c: corrects every measurement (docs/calibration.md). NULL: none */
  im2fit_data calibration_site_data; /* replaces the path */
  const char* pack_path; /* .i2p: contains tracker, index and body. Paths and data of single models override it */
  im2fit_data pack_data; /* replaces the path */
} im2fit_settings;

/* How a camera senses depth. It affects the outline of a person and therefore the girths. */
typedef enum im2fit_sensor {
  IM2FIT_SENSOR_UNKNOWN = 0,          /* estimated from the frames; docs/cameras lists when this fails */
  IM2FIT_SENSOR_STRUCTURED_LIGHT = 1, /* Kinect for Xbox 360, Xtion, Astra */
  IM2FIT_SENSOR_TIME_OF_FLIGHT = 2,   /* Kinect v2, Azure Kinect */
  IM2FIT_SENSOR_STEREO = 3 /* RealSense D400, OAK-D. Treated as structured light, the most similar kind in training */
} im2fit_sensor;

/* What is measured in addition to the front. */
typedef enum im2fit_turn {
  IM2FIT_TURN_NONE = 0,   /* nothing */
  IM2FIT_TURN_BACK = 1,   /* the back, after the person has turned it to the camera */
  IM2FIT_TURN_AROUND = 2, /* one slow full turn on the spot. Improves waist, hip and weight most; needs body_path */
  IM2FIT_TURN_WALK = 3    /* the person stands still, and the camera is carried round the person: each
                           * im2fit_frame needs its pose; needs body_path */
} im2fit_turn;

/* What the person wears. */
typedef enum im2fit_clothing {
  IM2FIT_CLOTHING_UNKNOWN = 0, /* estimated from the frames; needs body_path. Intervals widen with the uncertainty */
  IM2FIT_CLOTHING_BARE = 1, /* underwear or close-fitting sportswear. GUIDANCE_CLOTHED: more clothes were detected */
  IM2FIT_CLOTHING_DRESSED = 2 /* more clothes: the body under them is measured; wider intervals; needs body_path */
} im2fit_clothing;

/* Writes the defaults above, and NULL or 0 to all other fields. `struct_size` is sizeof(im2fit_settings) of the
 * caller's header. */
IM2FIT_API void im2fit_settings_init(im2fit_settings* settings, size_t struct_size);

/* Loads the files, allocates memory and starts the threads. The settings and the data they point to may be freed
 * after the call. `log` and `log_user` must stay valid until im2fit_close. *handle is NULL after an error. Allocates.
 * Errors:
 *   INVALID_ARGUMENT  a setting is out of range, or a required path is missing; the text names the field
 *   NOT_FOUND         a file does not exist
 *   IO                a file cannot be read, or a thread cannot be started
 *   CORRUPT           a file is damaged, of another kind, or of another format version
 *   UNSUPPORTED       tracker and index were not made together; clothing is DRESSED and the files do not support it;
 *                     struct_size is unknown, or a field is set that this library lacks
 *   NO_MEMORY */
IM2FIT_API int im2fit_open(const im2fit_settings* settings, im2fit_handle** handle);

/* Stops the threads, closes the attached source and frees the handle. Allowed in any state. Frames in the pipeline
 * are dropped. NULL does nothing. */
IM2FIT_API void im2fit_close(im2fit_handle* handle);

/* ---- Frames ---------------------------------------------------------------------------------------------------- */

/* Copies one upright depth frame into the engine. With settings.live = 0 it waits while the engine is behind. It also
 * waits while the accepted frames may be sufficient, so the call with the last frame returns after the measurement.
 *   depth_mm  16-bit millimetres, 0: no data
 *   stride    values (not bytes) from row to row; 0: width
 *   sequence  the camera's frame number, to count gaps; 0: none
 *   time_ns   the camera's monotonic time; 0: none
 * Errors:
 *   INVALID_ARGUMENT  the size is not that of the settings; the stride is less than the width; after im2fit_finish
 *   CORRUPT           the index is damaged, as for im2fit_finish */
IM2FIT_API int im2fit_push(im2fit_handle* handle, const uint16_t* depth_mm, int32_t width, int32_t height,
                           size_t stride, uint64_t sequence, int64_t time_ns);

/* Sample formats of a frame. */
typedef enum im2fit_format {
  IM2FIT_FORMAT_U16 = 0,     /* 16-bit integers in units of `unit_mm`; 0: no data */
  IM2FIT_FORMAT_DEPTH16 = 1, /* Android's ImageFormat.DEPTH16: 13 low bits are mm, 3 high bits confidence */
  IM2FIT_FORMAT_F32 = 2      /* 32-bit floats, metres. NaN, infinite, zero and negative: no data */
} im2fit_format;

/* A frame in the format and orientation of a camera or phone. Call im2fit_frame_init, then set the fields that are
 * known. Depths over 65535 mm count as no data. */
typedef struct im2fit_frame {
  size_t struct_size; /* written by im2fit_frame_init */
  const void* pixels; /* rows from the top; samples in the machine's byte order, aligned to their size */
  int32_t format;     /* IM2FIT_FORMAT_... */
  int32_t width;      /* as delivered. After rotate_deg the size must be that of the settings */
  int32_t height;
  /* 0, 90, 180, 270: clockwise rotation that makes the picture upright. The settings always describe the upright
   * picture. Its intrinsics follow from those of the picture as delivered, of `width` x `height`:
   *   90:  fx = fy, fy = fx, cx = height - 1 - cy, cy = cx           with width and height exchanged
   *   180: fx, fy,           cx = width - 1 - cx,  cy = height - 1 - cy
   *   270: fx = fy, fy = fx, cx = cy,              cy = width - 1 - cx   with width and height exchanged */
  int32_t rotate_deg;
  size_t row_bytes;            /* bytes from row to row, a multiple of the sample size; 0: no padding */
  float unit_mm;               /* 1: U16 only, above 0, up to 1000 */
  int32_t confidence_min;      /* 0: use all. DEPTH16: sevenths of full confidence, 0..7. Others: 0..255 */
  const uint8_t* confidence;   /* U16, F32: one byte per sample; less than confidence_min is no data. NULL: none */
  size_t confidence_row_bytes; /* bytes from row to row; 0: width */
  /* Intrinsics of this frame, in pixels of the frame as delivered. All 0: those of the settings. The first frame
   * after im2fit_open or im2fit_reset sets the intrinsics of the session. A later frame with other intrinsics is
   * resampled to them (nearest neighbour). Do not mix im2fit_push and im2fit_push_frame in one session. */
  float fx, fy, cx, cy;
  uint64_t sequence; /* as for im2fit_push */
  int64_t time_ns;
  int64_t device_us; /* time of the device's own clock; -1: none */
  /* Direction of gravity, of any length, in the axes of the frame as delivered: x right, y down, z forward. All 0:
   * unknown; then the latest known direction is used until im2fit_reset. Android's TYPE_GRAVITY points up: negate it.
   * Gravity defines the vertical where no floor is visible. */
  float down_x, down_y, down_z;
  float reserved; /* padding, so that the fields below keep their offsets: 0, as im2fit_frame_init writes it */
  /* Lens distortion of a picture that is not yet undistorted: the Brown-Conrady model of OpenCV, radial k,
   * tangential p. Android's LENS_DISTORTION has this order: k1 k2 k3 p1 p2. All 0: none. It is corrected with a
   * lookup table (nearest neighbour). The table is computed again when lens, intrinsics or rotation change. The first
   * table allocates. */
  float k1, k2, k3, p1, p2;
  float reserved2; /* padding, as `reserved`: 0 */
  /* Pose of a moving or hand-held camera, as the platform tracks it. turn_x .. turn_w is the unit quaternion from the
   * axes of the frame as delivered to static axes. x_mm .. z_mm is the position of the camera in the static axes,
   * within 1 km; all 0: the camera only rotates. All seven 0: unknown, and the frame is used without resampling.
   * Each frame is resampled to the view of the first frame with a pose (nearest neighbour). A rotation of more than
   * 10 degrees or a translation of more than 150 mm begins a new view. With settings.turn = IM2FIT_TURN_WALK, each
   * frame of a camera that moves at 0.15 m/s or more is a separate view. The first frame with a pose allocates.
   * ARKit and OpenGL have y up and z backwards: negate y and z of the camera's axes. The quaternion (x, y, z, w) then
   * becomes (w, z, -y, -x). */
  float turn_x, turn_y, turn_z, turn_w;
  float x_mm, y_mm, z_mm;
  float reserved3; /* padding, as `reserved`: 0 */
} im2fit_frame;

/* Writes the defaults above, and NULL or 0 to all other fields. `struct_size` is sizeof(im2fit_frame) of the caller's
 * header. */
IM2FIT_API void im2fit_frame_init(im2fit_frame* frame, size_t struct_size);

/* Converts a frame to upright millimetres and pushes it as im2fit_push does. The same scene gives bit-identical
 * results in each of the three formats.
 * Errors:
 *   INVALID_ARGUMENT  a field is out of range, or a reserved field is not 0; the text names the field; or as for
 *                     im2fit_push
 *   CORRUPT           the index is damaged, as for im2fit_finish
 *   UNSUPPORTED       struct_size is unknown, or a field is set that this library lacks */
IM2FIT_API int im2fit_push_frame(im2fit_handle* handle, const im2fit_frame* frame);

/* Waits until the engine has processed all pushed frames, so that im2fit_poll includes them. Negative `timeout_ms`:
 * no limit.
 * Errors:
 *   TIMEOUT           call again
 *   CORRUPT           the index is damaged, as for im2fit_finish */
IM2FIT_API int im2fit_wait(im2fit_handle* handle, int32_t timeout_ms);

/* Ends the stream: waits for the frames in the pipeline and measures with the accepted frames. At least
 * settings.frames_min are needed. A second call does nothing. im2fit_result.measured, not the status, reports whether
 * there is a measurement. Afterwards im2fit_push is refused until im2fit_reset, im2fit_next, or im2fit_select_user
 * with another id.
 * Errors: CORRUPT: the index is damaged. A large index is checked when it is read, not when it is opened. */
IM2FIT_API int im2fit_finish(im2fit_handle* handle);

/* Begins a session for a new person and discards all frames, the floor and the ids. Allowed between frames and after
 * im2fit_finish. Waits for the frames in the pipeline. */
IM2FIT_API int im2fit_reset(im2fit_handle* handle);

/* Prepares for the next person. Waits for the frames in the pipeline. Unlike im2fit_reset, it keeps the floor and the
 * ids.
 * After MEASURED: frames are processed again. State and measurement stay until the measured person has been outside
 * the picture for half a second. Then a new session begins automatically, and im2fit_result.session increases.
 * Before MEASURED: a new session begins at once. */
IM2FIT_API int im2fit_next(im2fit_handle* handle);

/* From the next frame on, only the person with this user_id is measured. 0, the default: the first person whose
 * guidance is empty. An id other than the current one begins a new session at once. Waits for the frames in the
 * pipeline.
 * Errors: INVALID_ARGUMENT: the id is negative. */
IM2FIT_API int im2fit_select_user(im2fit_handle* handle, int32_t user_id);

/* From the next frame on, only people whose feet are within this rectangle on the floor are measured. x points to the
 * right as seen by the camera, z away from the camera. The origin is the point under the camera. Four zeros, the
 * default: everywhere. The session continues. If its person is outside the rectangle, that person counts as having
 * left. Waits for the frames in the pipeline.
 * Errors: INVALID_ARGUMENT: a number is not finite or above 20000, or x0 < x1 and z0 < z1 do not hold. */
IM2FIT_API int im2fit_set_region(im2fit_handle* handle, float x0_mm, float z0_mm, float x1_mm, float z1_mm);

/* Facts that the person reports. They are used together with the frames. Call im2fit_known_init, then set what is
 * known. A known weight makes girths more accurate. */
typedef enum im2fit_sex { IM2FIT_SEX_UNKNOWN = 0, IM2FIT_SEX_WOMAN = 1, IM2FIT_SEX_MAN = 2 } im2fit_sex;
typedef struct im2fit_known {
  size_t struct_size;  /* written by im2fit_known_init */
  float stature_mm;    /* barefoot, 500..2500; 0: not known */
  float stature_sd_mm; /* standard deviation, 0.1..1000. 0: 20, for a reported stature. Use 5 for a measured one */
  float weight_kg;     /* 15..400; 0: not known */
  float weight_sd_kg;  /* 0.1..1000. 0: 3, for a reported weight. Use 0.7 for a weight from a scale */
  float age_years;     /* up to 120; 0: not known. Add 0.5 to completed years */
  float age_sd_years;  /* 0.1..5. 0: 0.5 */
  int32_t sex;         /* IM2FIT_SEX_... */
  int32_t reserved;    /* padding for a later field: 0 */
} im2fit_known;

/* Facts of im2fit_result.known_used and known_doubted. */
typedef enum im2fit_known_fact {
  IM2FIT_KNOWN_STATURE = 1 << 0,
  IM2FIT_KNOWN_WEIGHT = 1 << 1,
  IM2FIT_KNOWN_SEX = 1 << 2,
  IM2FIT_KNOWN_AGE = 1 << 3
} im2fit_known_fact;

/* Sets all facts to unknown. `struct_size` is sizeof(im2fit_known) of the caller's header. */
IM2FIT_API void im2fit_known_init(im2fit_known* known, size_t struct_size);

/* Sets the facts about the person of this session, before, during or after the frames. All measurements, their
 * intervals, the size, the tape, the body and the garments change together. A second call replaces the first, so a
 * corrected fact needs no new capture. After im2fit_next the facts apply to the next person, even while the measured
 * person is still in the picture. A new session has no facts: call this function for each person. Facts are kept in
 * memory only. im2fit_result_json contains them.
 * A stature or weight that contradicts the frames is not used: im2fit_result.known_doubted names it. Ask the person
 * again. Call this function on the thread that calls im2fit_push.
 * Errors:
 *   INVALID_ARGUMENT  a value is out of range; the text names it. Earlier facts are kept
 *   UNSUPPORTED       struct_size is unknown, or a field is set that this library lacks */
IM2FIT_API int im2fit_set_known(im2fit_handle* handle, const im2fit_known* known);

/* ---- Sources by URI (optional) --------------------------------------------------------------------------------- */

/* An open source. The opener writes it. */
typedef struct im2fit_source {
  void* user;
  /* Waits up to `timeout_ms` for a frame and writes it: upright, width x height of the settings, rows without
   * padding. Returns IM2FIT_OK, TIMEOUT, END_OF_STREAM, CORRUPT (this frame is skipped), NO_DEVICE or IO. */
  int (*next)(void* user, uint16_t* depth_mm, int32_t width, int32_t height, int32_t timeout_ms, uint64_t* sequence,
              int64_t* time_ns);
  void (*close)(void* user); /* called once; may be NULL */
} im2fit_source;

/* Opens `uri` and writes *source. Returns IM2FIT_OK or an error. After an error *source is not used. im2fit_attach
 * and im2fit_pump report a number that is not a status of this header, such as 42, as IO. The text contains the
 * number. */
typedef int (*im2fit_opener_fn)(void* opener_user, const char* uri, im2fit_source* source);

/* Sets the function that opens URIs for this handle. NULL: none. libim2fit itself opens no cameras.
 * libim2fit-cameras has an opener for them (im2fit/cameras.h). */
IM2FIT_API int im2fit_set_opener(im2fit_handle* handle, im2fit_opener_fn opener, void* opener_user);

/* Writes the direction of gravity for the latest frame of the source with this `user` to `down`: any length but 0,
 * in the axes of that frame (x right, y down, z forward). Returns 1; or 0 if unknown: the earlier direction is kept.
 * im2fit_pump calls it after each frame. */
typedef int (*im2fit_down_fn)(void* user, float down[3]);

/* Sets the gravity function for sources that are attached later. NULL, the default: their gravity is unknown. See
 * im2fit_frame.down_x for the use of gravity. */
IM2FIT_API int im2fit_set_opener_down(im2fit_handle* handle, im2fit_down_fn down);

/* Closes the attached source, if any, and opens `uri` with the opener.
 * Errors:
 *   INVALID_ARGUMENT  the opener set no next()
 *   UNSUPPORTED       there is no opener
 *   IO                the opener returned a number that is not a status
 *   others            as returned by the opener
 * Allocates. */
IM2FIT_API int im2fit_attach(im2fit_handle* handle, const char* uri);

/* Takes one frame from the attached source and pushes it. Waits up to `timeout_ms` for it.
 * Errors:
 *   TIMEOUT           no frame in time: call again
 *   END_OF_STREAM     the source has ended: call im2fit_finish
 *   CORRUPT           the frame is damaged and skipped: call again. Or the index is damaged, as for im2fit_finish;
 *                     then every further call returns CORRUPT, and so does im2fit_wait
 *   NO_DEVICE         the camera was unplugged: call im2fit_finish, or attach it again
 *   INVALID_ARGUMENT  no source is attached; its frames have another size; after im2fit_finish
 *   IO                next() returned IO, or a number that is not a status
 *   others            as returned by next() */
IM2FIT_API int im2fit_pump(im2fit_handle* handle, int32_t timeout_ms);

/* Closes the attached source, if any. im2fit_close does that too. */
IM2FIT_API int im2fit_detach(im2fit_handle* handle);

/* ---- Models ---------------------------------------------------------------------------------------------------- */

typedef struct im2fit_models {
  const char* made_by;    /* the program that made the index, and its input; valid until im2fit_close */
  uint32_t people;        /* number of people in the index */
  uint32_t captures;      /* number of captures of these people in the index */
  uint32_t tracker_key;   /* identifies the tracker; im2fit_open refuses an index made with another */
  int32_t has_body;       /* 1: there is body data, so meshes, tape, avatars and garments are available */
  int32_t answers_shape;  /* 1: a shape is fitted to the depth. 0: measurements are less accurate: there is no body */
                          /* data, or it is not the body data that the index was made with */
  int32_t answers_turned; /* 1: the index covers people from behind, so settings.turn is useful */
  int32_t answers_clothed; /* 1: the index covers people in clothes */
  int32_t site_corrected;  /* 1: measurements are corrected for the site (settings.calibration_site_path) */
} im2fit_models;

/* Describes the models of the handle, for a support page or to check that the models have the required features.
 * `struct_size` is sizeof *models of the caller's header. */
IM2FIT_API int im2fit_get_models(im2fit_handle* handle, im2fit_models* models, size_t struct_size);

/* ---- Results --------------------------------------------------------------------------------------------------- */

typedef enum im2fit_state {
  IM2FIT_STATE_SEARCHING = 0, /* no person yet */
  IM2FIT_STATE_USER_FOUND,    /* a person is found but cannot be measured yet: see the guidance */
  IM2FIT_STATE_CALIBRATING,   /* waiting for the raised arms of settings.calibration_psi */
  IM2FIT_STATE_TRACKING,      /* accumulating frames */
  /* The measurement is complete and does not change. Frames are ignored until im2fit_next, im2fit_reset, or
   * im2fit_select_user with another id. After im2fit_next the state stays MEASURED until the measured person has
   * left. */
  IM2FIT_STATE_MEASURED,
  /* The person has left. The session begins again when a person is found. The number of such restarts is limited
   * until im2fit_reset or im2fit_next. */
  IM2FIT_STATE_LOST,
  /* settings.turn: the front is measured (im2fit_result.front_measured). TURN_BACK: frames of the back are being
   * accumulated. TURN_AROUND, TURN_WALK: the person is tracked during the turn. MEASURED follows. It uses the front
   * only if too little of the back, or of the turn (150 degrees), was seen within 450 frames. */
  IM2FIT_STATE_TURNING
} im2fit_state;

/* What must change about the person or the scene: bits of im2fit_result.guidance. */
typedef enum im2fit_guidance {
  IM2FIT_GUIDANCE_NO_PERSON = 1 << 0,
  IM2FIT_GUIDANCE_TOO_NEAR = 1 << 1,
  IM2FIT_GUIDANCE_TOO_FAR = 1 << 2,
  IM2FIT_GUIDANCE_FEET_CUT = 1 << 3,
  IM2FIT_GUIDANCE_HEAD_CUT = 1 << 4,
  IM2FIT_GUIDANCE_ARMS_CLOSE = 1 << 5,
  IM2FIT_GUIDANCE_NOT_FRONTAL = 1 << 6,
  IM2FIT_GUIDANCE_NOT_UPRIGHT = 1 << 7,
  IM2FIT_GUIDANCE_MOVING = 1 << 8,
  IM2FIT_GUIDANCE_SEVERAL_PEOPLE = 1 << 9,
  IM2FIT_GUIDANCE_TOO_NOISY = 1 << 10,
  IM2FIT_GUIDANCE_SIDE_CUT = 1 << 11,
  IM2FIT_GUIDANCE_CALIBRATION_POSE = 1 << 12, /* raise the arms: upper arms level, hands up */
  IM2FIT_GUIDANCE_TURN_ROUND = 1 << 13,       /* turn the back to the camera. Show this before all other guidance */
  IM2FIT_GUIDANCE_CLOTHED = 1 << 14,          /* measured, but settings.clothing is BARE and clothes were detected */
  IM2FIT_GUIDANCE_TURN_ON = 1 << 15,     /* make one full turn slowly on the spot. The person cannot see a screen */
  IM2FIT_GUIDANCE_TURN_SLOWER = 1 << 16, /* turn or walk more slowly */
  IM2FIT_GUIDANCE_WALK_ROUND = 1 << 17,  /* for the holder of the camera: continue round the person */
  /* Not measured: the person is shorter or taller than all training people. */
  IM2FIT_GUIDANCE_OUT_OF_POPULATION = 1 << 18,
  /* Not measured: a flat floor is curved in the depth data. The lens distortion is not corrected, or the frames hold
   * distances instead of depths. */
  IM2FIT_GUIDANCE_FLOOR_BENT = 1 << 19,
  /* Accompanies a measurement: the feet are on an object above the floor, and heights are measured from there. Or the
   * person wears high heels, and their mean effect was taken off the stature. */
  IM2FIT_GUIDANCE_FEET_RAISED = 1 << 20,
  /* Accompanies a measurement: the top of the head has no depth. The interval of the stature extends upwards. */
  IM2FIT_GUIDANCE_HEAD_UNSEEN = 1 << 21,
  /* The person cannot be separated from a wall or shelf: step away from it. */
  IM2FIT_GUIDANCE_STEP_TO_THE_MIDDLE = 1 << 22,
  IM2FIT_GUIDANCE_DEPTH_MISSING = 1 << 23 /* a part of the body has no depth: dark or shiny clothes */
} im2fit_guidance;
#define IM2FIT_GUIDANCE_COUNT 24

/* The person's own left and right arm: bits. */
typedef enum im2fit_arm { IM2FIT_ARM_LEFT = 1 << 0, IM2FIT_ARM_RIGHT = 1 << 1 } im2fit_arm;

/* The side of the person that faces the camera. */
typedef enum im2fit_view {
  IM2FIT_VIEW_UNKNOWN = 0,
  IM2FIT_VIEW_FRONT,
  IM2FIT_VIEW_BACK,
  IM2FIT_VIEW_SIDE /* neither front nor back */
} im2fit_view;

/* The views used for a measurement. */
typedef enum im2fit_views {
  IM2FIT_VIEWS_NONE = 0, /* no measurement */
  IM2FIT_VIEWS_FRONT,
  IM2FIT_VIEWS_FRONT_AND_BACK,
  IM2FIT_VIEWS_AROUND /* the front and a turn of at least 150 degrees */
} im2fit_views;

/* Measurements of the unclothed body in a relaxed standing pose. A girth is the perimeter of the convex hull of a
 * section (docs/result.md). */
typedef enum im2fit_measurement {
  IM2FIT_STATURE = 0,
  IM2FIT_SLEEVE_LENGTH,
  IM2FIT_LEG_LENGTH,
  IM2FIT_SHOULDER_BREADTH,
  IM2FIT_NECK_GIRTH,
  IM2FIT_SHOULDER_GIRTH,
  IM2FIT_CHEST_GIRTH,
  IM2FIT_WAIST_GIRTH,
  IM2FIT_HIP_GIRTH,
  IM2FIT_INSIDE_LEG,
  IM2FIT_WEIGHT
} im2fit_measurement;
#define IM2FIT_MEASUREMENT_COUNT 11

/* Joints, in the order HE NE TO LS RS LE RE LA RA LH RH LK RK LF RF: head, neck, torso, then left and right
 * shoulder, elbow, hand, hip, knee, foot. */
#define IM2FIT_JOINT_COUNT 15

typedef struct im2fit_estimate {
  float value; /* mm; weight: kg; age: years */
  float low;   /* 95 % interval */
  float high;
} im2fit_estimate;

typedef struct im2fit_joint {
  float x, y, z;    /* mm, camera axes */
  float confidence; /* 0..1: probability that the error is below 50 mm. Below 0.25: not visible, inferred */
} im2fit_joint;

/* A person in view. */
typedef struct im2fit_user {
  int32_t id;                       /* >= 1 */
  int32_t left, top, right, bottom; /* pixels of the upright picture, inclusive */
  float x, y, z;                    /* centroid of the visible surface: mm, camera axes */
} im2fit_user;
#define IM2FIT_USER_COUNT_MAX 8
#define IM2FIT_AGE_BAND_COUNT 4

typedef struct im2fit_result {
  int32_t state;          /* IM2FIT_STATE_... */
  uint32_t guidance;      /* of the latest frame. After the measurement: 0 or CLOTHED */
  uint32_t guidance_seen; /* bitwise OR over all frames of the session */
  int32_t has_joints;     /* 1: `joints` is of the latest frame; after the measurement, the mean of the used frames */
  uint64_t frames_seen;   /* processed before the measurement */
  uint64_t frames_used;   /* accumulated for the measurement */
  uint64_t frames_dropped;   /* live = 1: dropped because the engine was behind */
  uint64_t sequence_gaps;    /* skipped sequence numbers */
  uint64_t sequence_repeats; /* frames whose sequence number did not increase */
  uint64_t time_reversals;   /* frames whose time_ns did not increase */
  im2fit_joint joints[IM2FIT_JOINT_COUNT];
  int32_t measured; /* 1: the measurement is complete. Its values are valid if this or front_measured is 1 */
  float female;     /* probability, 0..1 */
  im2fit_estimate measurements[IM2FIT_MEASUREMENT_COUNT];
  float paper[IM2FIT_MEASUREMENT_COUNT]; /* values of the published method; NaN: it has none */
  uint32_t index_entry;                  /* the entry of the index nearest to the person */
  float index_distance;                  /* distance to it, in the index */
  int32_t user_id;          /* the person of `joints` and `guidance`: >= 1, never reused. 0: no person in view */
  int32_t view;             /* IM2FIT_VIEW_..., of the latest frame */
  uint32_t joints_inferred; /* a bit for each of display_joints: not visible, kept at its last position */
  uint32_t session; /* number of the session: increases after im2fit_next and im2fit_select_user; im2fit_reset: 0 */
  /* Joints of the latest frame for display, also after the measurement. Confidence is 0 while no person is tracked.
   * They are smoothed, with a delay of 0.11 s at rest and 0.02 s at a speed of 1 m/s. `joints` are not smoothed. */
  im2fit_joint display_joints[IM2FIT_JOINT_COUNT];
  int32_t user_count; /* number of `users`: all people in view, nearest first */
  im2fit_user users[IM2FIT_USER_COUNT_MAX];
  int32_t front_measured; /* 1: from TURNING on. Until `measured` the values are preliminary and use the front only */
  int32_t views;          /* IM2FIT_VIEWS_..., of the measurement */
  uint32_t frames_back;   /* number of frames_used that show the back, or the turn */
  im2fit_estimate age;    /* years: median and 95 % interval of similar people in the index */
  float age_bands[IM2FIT_AGE_BAND_COUNT]; /* probabilities of 18-25, 25-45, 45-65, 65-75 years */
  uint32_t arms_close;                    /* IM2FIT_ARM_... bits: the arms to which ARMS_CLOSE in `guidance` refers */
  float clothing_probability;             /* of wearing clothes, from the frames alone; NaN: not estimated */
  float clothing_ease_mm;                 /* expected gap between cloth and skin at the trunk; NaN: not estimated */
  uint32_t known_used;                    /* IM2FIT_KNOWN_... bits: facts of im2fit_set_known that were used */
  uint32_t known_doubted; /* IM2FIT_KNOWN_... bits: facts rejected because the frames contradict them */
  /* TURN_AROUND, TURN_WALK, from TURNING on: the largest angle that the person has turned relative to the camera;
   * positive to the person's left. */
  float turned_deg;
  /* settings.frames_wanted, for a progress bar: show frames_used out of this number; with TURN_BACK, from TURNING on,
   * frames_back out of this number. A full turn has no fixed number of frames: show turned_deg. */
  int32_t frames_wanted;
  /* Users who are not measured. Bit i is users[i]. users_outside: outside of im2fit_set_region. users_still: a figure
   * that does not move while another person sways, such as a mannequin. im2fit_select_user can still measure it. */
  uint32_t users_outside;
  uint32_t users_still;
} im2fit_result;

/* Copies the latest result. All its fields belong together. Never waits for the engine. Any thread. `struct_size` is
 * sizeof *result of the caller's header. A caller built with an older header gets the fields of that header.
 * The text of an error is in im2fit_last_error(NULL) only. */
IM2FIT_API int im2fit_poll(const im2fit_handle* handle, im2fit_result* result, size_t struct_size);

/* The frame and the person of a mask. */
typedef struct im2fit_mask_info {
  int32_t width, height; /* pixels of the mask: those of the settings */
  int32_t user_id;       /* the person, as im2fit_result.user_id; 0: no person is in view, and the mask is empty */
  int32_t reserved;      /* padding for a later field: 0 */
  uint64_t sequence;     /* of the frame, as pushed: draw the mask over the picture of this frame */
  int64_t time_ns;
} im2fit_mask_info;

/* Copies the mask of the person of im2fit_result.user_id in the latest processed frame. Any thread. Waits for the
 * copy of one mask at most. After the measurement frames are not processed, so the mask is that of the last processed
 * frame.
 *   mask         width x height bytes, rows from the top without padding: 255 the person, 0 everything else. The
 *                pixels are those of the upright picture. A frame with a pose is resampled to the first view
 *                (im2fit_frame.turn_x). NULL with a capacity of 0: only `info` is written
 *   capacity     bytes at `mask`
 *   info         may be NULL if `mask` is not
 *   struct_size  sizeof *info of the caller's header
 * After the first call the handle keeps masks, starting with the next frame. This costs one copy of a mask per frame.
 * Errors:
 *   INVALID_ARGUMENT  `mask` is NULL with a capacity, or `mask` and `info` are both NULL
 *   NOT_FOUND         no frame was processed since the first call, or since im2fit_reset: call again after a frame
 *   TOO_SMALL         `capacity` is less than width x height; `info` is written
 *   NO_MEMORY
 * The text of an error is in im2fit_last_error(NULL) only. Allocates in the first call. */
IM2FIT_API int im2fit_mask(const im2fit_handle* handle, uint8_t* mask, size_t capacity, im2fit_mask_info* info,
                           size_t struct_size);

typedef struct im2fit_size {
  char name[32];     /* "M"; "<XS" and ">3XL": outside the chart */
  float probability; /* 0..1; all sizes sum to 1 */
} im2fit_size;

/* Writes the sizes of the chart, small to large, with their probabilities. *count gets the number of sizes. *best
 * (may be NULL) gets the index of the most probable size. With a capacity of 0, `sizes` may be NULL.
 * Errors:
 *   NOT_MEASURED  there is no measurement yet; *count is 0
 *   TOO_SMALL     `capacity` is less than *count: call again with that
 *   CORRUPT       the index is damaged, as for im2fit_finish
 * Allocates. */
IM2FIT_API int im2fit_sizes(im2fit_handle* handle, im2fit_size* sizes, size_t capacity, size_t* count, size_t* best);

/* Status of a measurement of the tape. */
typedef enum im2fit_tape_status {
  IM2FIT_TAPE_MEASURED = 0,
  IM2FIT_TAPE_REFUSED, /* never measured: the depth camera or the body model does not show it */
  IM2FIT_TAPE_ABSENT   /* this body has no such section */
} im2fit_tape_status;

typedef struct im2fit_tape_value {
  int32_t status;     /* IM2FIT_TAPE_... */
  float value;        /* mm; weight: kg. NaN if not MEASURED */
  float low, high;    /* 95 % interval. NaN if not MEASURED, or if the interval is not known */
  const char* reason; /* why there is no value, one sentence; NULL when MEASURED. Constant */
} im2fit_tape_value;

/* Writes measurements of the fitted mesh by the definitions of the tape (docs/tape.md). values[i] belongs to
 * ids[i], an id of im2fit_tape_id. With ids = NULL: the first `id_count` definitions of that list. `value_size` is
 * sizeof(im2fit_tape_value) of the caller's header, and the distance in bytes from value to value. The eleven
 * im2fit_result.measurements are included with the values of the mesh and the same intervals. After an error no value
 * is written.
 * Errors:
 *   INVALID_ARGUMENT  an id is NULL; value_size is too small; ids is NULL and id_count exceeds im2fit_tape_count()
 *   NOT_FOUND         an id is unknown; the text names it
 *   NOT_MEASURED      there is no measurement yet
 *   UNSUPPORTED       the handle has no body data (settings.body_path)
 *   CORRUPT           the index is damaged, as for im2fit_finish
 * Allocates. */
IM2FIT_API int im2fit_tape(im2fit_handle* handle, const char* const* ids, size_t id_count, im2fit_tape_value* values,
                           size_t value_size);

/* Writes the person as a mesh in the measured pose. It is the fitted body whose measurements are as close as possible
 * to im2fit_result.measurements (im2fit_body_residual). Units are mm. x points to the person's left, y up, z to the
 * front; the soles are at y = 0.
 *   vertices   3 x vertex_capacity floats: x y z of each vertex. NULL: not written
 *   triangles  3 x triangle_capacity vertex indices, counter-clockwise from outside. NULL: not written
 *   ..._count  always written: the counts of vertices and triangles. 0 without body data
 * Errors:
 *   NOT_MEASURED  there is no measurement yet
 *   TOO_SMALL     a capacity is less than its count
 *   UNSUPPORTED   the handle has no body data (settings.body_path)
 *   CORRUPT       the index is damaged, as for im2fit_finish
 * Allocates. For each person, the first function that needs the body takes a few hundredths of a second. */
IM2FIT_API int im2fit_body_mesh(im2fit_handle* handle, float* vertices, size_t vertex_capacity, size_t* vertex_count,
                                int32_t* triangles, size_t triangle_capacity, size_t* triangle_count);

/* Writes the differences between the measurements of the fitted body and im2fit_result.measurements, by id: mm,
 * weight in kg. They are below 1 mm if a body with all reported measurements exists. Otherwise they are larger:
 * inform the user if a difference of more than 2 mm of a girth matters.
 * Errors:
 *   NOT_MEASURED  there is no measurement yet
 *   UNSUPPORTED   the handle has no body data (settings.body_path)
 *   CORRUPT       the index is damaged, as for im2fit_finish
 * Allocates. */
IM2FIT_API int im2fit_body_residual(im2fit_handle* handle, float residual[IM2FIT_MEASUREMENT_COUNT]);

/* Writes the result as JSON (docs/result.md), in any state: UTF-8, terminated by a zero byte. *length gets the number
 * of bytes without the zero. With a capacity of 0, `text` may be NULL. Without body data the JSON lacks the body and
 * the values that need it.
 * Errors:
 *   TOO_SMALL    `capacity` is less than *length + 1: call again with that
 *   UNSUPPORTED  the library was built without JSON
 *   CORRUPT      the index is damaged, as for im2fit_finish
 * Allocates. */
IM2FIT_API int im2fit_result_json(im2fit_handle* handle, char* text, size_t capacity, size_t* length);

typedef enum im2fit_avatar_format {
  IM2FIT_AVATAR_GLB = 0,
  IM2FIT_AVATAR_OBJ = 1,
  IM2FIT_AVATAR_BVH = 2
} im2fit_avatar_format;

/* Writes the person as the bytes of a .glb, .obj or .bvh file (docs/formats-body.md). `format` is
 * IM2FIT_AVATAR_.... *size gets the number of bytes. With a capacity of 0, `bytes` may be NULL. The .obj has
 * texture coordinates but names no material library, because there is no second file. Its texture is the image in the
 * .glb.
 * Errors:
 *   INVALID_ARGUMENT  the format is unknown
 *   NOT_MEASURED      there is no measurement yet
 *   TOO_SMALL         `capacity` is less than *size: call again with that
 *   UNSUPPORTED       the handle has no body data (settings.body_path), or the library was built without avatars
 *   CORRUPT           the index is damaged, as for im2fit_finish
 * Allocates. */
IM2FIT_API int im2fit_avatar(im2fit_handle* handle, int32_t format, void* bytes, size_t capacity, size_t* size);

/* A pose for the nodes 0 to 18 of the .glb of im2fit_avatar or im2fit_dressed_avatar, in the order and axes of the
 * file: y up, metres, the hips above the origin, the lower foot at y = 0. Set the translation of node 0 and the
 * rotation of every node. Do not change the other translations. */
#define IM2FIT_RIG_NODE_COUNT 19
typedef struct im2fit_rig {
  float root_m[3];                           /* x y z: translation of node 0 */
  float rotations[IM2FIT_RIG_NODE_COUNT][4]; /* unit quaternions x y z w, relative to the parent node */
  int32_t user_id;                           /* the tracked person */
  uint32_t joints_inferred;                  /* as in im2fit_result: joints that are inferred */
} im2fit_rig;

/* Writes the pose of the latest frame (im2fit_result.display_joints) for the avatar of the measured person. It
 * changes after im2fit_next, when frames are processed again, until the next session begins. `struct_size` is sizeof
 * *rig of the caller's header.
 * Errors:
 *   NOT_FOUND     no person is tracked in the latest frame
 *   NOT_MEASURED  there is no measurement
 *   UNSUPPORTED   the handle has no body data (settings.body_path), or the library was built without avatars
 *   CORRUPT       the index is damaged, as for im2fit_finish
 * Allocates in the first call for each person. */
IM2FIT_API int im2fit_live_rig(im2fit_handle* handle, im2fit_rig* rig, size_t struct_size);

/* ---- Garments (docs/garments.md) ------------------------------------------------------------------------------- */

/* How a garment fits in a region. */
typedef enum im2fit_verdict {
  IM2FIT_FIT_TIGHT = 0, /* too small: it constricts the body */
  IM2FIT_FIT_SNUG,      /* closer than designed */
  IM2FIT_FIT_GOOD,      /* as designed */
  IM2FIT_FIT_LOOSE      /* wider than designed */
} im2fit_verdict;

typedef struct im2fit_region_fit {
  const char* name;      /* "chest"; constant */
  float ease_mm;         /* girth of the finished garment minus girth of the body */
  float low_mm, high_mm; /* 95 % interval */
  int32_t verdict;       /* IM2FIT_FIT_..., of ease_mm */
} im2fit_region_fit;
#define IM2FIT_REGION_COUNT_MAX 8

typedef struct im2fit_size_fit {
  char name[32];        /* "M" */
  float cost;           /* 0: as designed in all regions. Comparable only between sizes of the same garment */
  int32_t region_count; /* of `regions`; the same for all sizes of a garment */
  im2fit_region_fit regions[IM2FIT_REGION_COUNT_MAX];
} im2fit_size_fit;

/* Writes how each size of a garment would fit, from small to large. The sizes are those of the chart for the person's
 * sex.
 *   garment   an id of im2fit_garment_id
 *   fits      `capacity` entries; NULL with a capacity of 0
 *   fit_size  sizeof(im2fit_size_fit) of the caller's header, and the distance in bytes from entry to entry
 *   count     gets the number of sizes
 *   best      (may be NULL) gets the index of the best size. No size fits if the best one is TIGHT in a region, or
 *             LOOSE in all
 * Errors:
 *   INVALID_ARGUMENT  the garment is NULL, or fit_size is too small
 *   NOT_FOUND         the garment is unknown; the text names it
 *   NOT_MEASURED      there is no measurement yet
 *   TOO_SMALL         `capacity` is less than *count: call again with that
 *   UNSUPPORTED       the handle has no body data (settings.body_path), or the body lacks a girth of the garment
 *   CORRUPT           the index is damaged, as for im2fit_finish
 * Allocates. */
IM2FIT_API int im2fit_garment_fit(im2fit_handle* handle, const char* garment, im2fit_size_fit* fits, size_t fit_size,
                                  size_t capacity, size_t* count, size_t* best);

typedef struct im2fit_worn {
  const char* garment; /* an id of im2fit_garment_id */
  const char* size;    /* a size of the chart, "M"; NULL: the best size */
} im2fit_worn;
#define IM2FIT_WORN_COUNT_MAX 4

/* Writes the .glb of im2fit_avatar with garments, draped on the body in the measured pose. `worn` has `worn_count`
 * entries, at most IM2FIT_WORN_COUNT_MAX, innermost first. With a `worn_count` of 0: trousers and a T-shirt of the
 * best sizes. *size gets the number of bytes. With a capacity of 0, `bytes` may be NULL. The handle keeps the
 * latest file, so a call with a capacity of 0 and a second call with a buffer drape only once. Draping takes a tenth
 * of a second per garment and some megabytes.
 * Errors:
 *   INVALID_ARGUMENT  worn_count exceeds the maximum, or a garment is NULL
 *   NOT_FOUND         a garment or size is unknown; the text names it
 *   NOT_MEASURED      there is no measurement yet
 *   TOO_SMALL         `capacity` is less than *size: call again with that
 *   UNSUPPORTED       the handle has no body data (settings.body_path); the body lacks a girth of a garment; or the
 *                     library was built without avatars or garments
 *   CORRUPT           the index is damaged, as for im2fit_finish
 * Allocates. */
IM2FIT_API int im2fit_dressed_avatar(im2fit_handle* handle, const im2fit_worn* worn, size_t worn_count, void* bytes,
                                     size_t capacity, size_t* size);

/* ---- Names ----------------------------------------------------------------------------------------------------- */

/* Why no person is found in a frame. */
typedef enum im2fit_diagnosis_code {
  IM2FIT_DIAGNOSIS_NONE = 0,
  IM2FIT_DIAGNOSIS_LITTLE_DEPTH = 1,    /* very few pixels have depth */
  IM2FIT_DIAGNOSIS_RAW_DISPARITY = 2,   /* values are the 11-bit disparity of a Kinect */
  IM2FIT_DIAGNOSIS_BYTES_SWAPPED = 3,   /* the byte order of the values is wrong */
  IM2FIT_DIAGNOSIS_PLAYER_BITS = 4,     /* the three low bits are not depth */
  IM2FIT_DIAGNOSIS_CONFIDENCE_BITS = 5, /* the three high bits are not depth: use IM2FIT_FORMAT_DEPTH16 */
  IM2FIT_DIAGNOSIS_FLOAT_VALUES = 6,    /* floating-point values were read as 16-bit integers */
  IM2FIT_DIAGNOSIS_NO_DEPTH_PICTURE = 7,
  IM2FIT_DIAGNOSIS_UNIT = 8,          /* values are not millimetres: see unit_mm */
  IM2FIT_DIAGNOSIS_ROTATED = 9,       /* the camera is on its side: see rotate_deg */
  IM2FIT_DIAGNOSIS_CENTRE = 10,       /* cx and cy belong to the other orientation of the picture */
  IM2FIT_DIAGNOSIS_FIELD_OF_VIEW = 11 /* fx and fy give less than 25 or more than 130 degrees */
} im2fit_diagnosis_code;

typedef struct im2fit_diagnosis {
  int32_t code;       /* IM2FIT_DIAGNOSIS_... */
  int32_t rotate_deg; /* ROTATED: the rotation that makes the picture upright; otherwise 0 */
  float unit_mm;      /* UNIT and PLAYER_BITS: millimetres per unit; 0: not known */
  char text[244];     /* likely cause and remedy in English, as printed by the programs; "" for NONE */
} im2fit_diagnosis;

/* Finds the reason why no person is found. Takes an upright frame in the format of im2fit_push and uses the
 * intrinsics of the settings. Does not measure and does not change the session. It can take some tenths of a second:
 * call it when no person has been found for several seconds, not for every frame. `struct_size` is
 * sizeof(im2fit_diagnosis) of the caller's header.
 * Errors: INVALID_ARGUMENT: depth_mm or diagnosis is NULL; the size is not that of the settings; the stride is less
 * than the width. */
IM2FIT_API int im2fit_diagnose(im2fit_handle* handle, const uint16_t* depth_mm, int32_t width, int32_t height,
                               size_t stride, im2fit_diagnosis* diagnosis, size_t struct_size);

/* Names as in result.json. NULL for a number out of range. They need no handle: any thread, at any time. */

IM2FIT_API const char* im2fit_state_name(int state);    /* "TRACKING" */
IM2FIT_API const char* im2fit_guidance_name(int bit);   /* 0..23: "TOO_NEAR" is bit 1 */
IM2FIT_API const char* im2fit_diagnosis_name(int code); /* "UNIT"; "" for NONE */
IM2FIT_API const char* im2fit_measurement_name(int id); /* "chest_girth" */
IM2FIT_API const char* im2fit_measurement_unit(int id); /* "mm" or "kg" */
IM2FIT_API const char* im2fit_joint_name(int joint);    /* "HE" */
IM2FIT_API const char* im2fit_view_name(int view);      /* "front" */
IM2FIT_API size_t im2fit_tape_count(void);              /* number of definitions of the tape */
IM2FIT_API const char* im2fit_tape_id(size_t index);    /* "thigh_girth" */
IM2FIT_API const char* im2fit_tape_unit(size_t index);  /* "mm" or "kg" */
IM2FIT_API const char* im2fit_tape_iso(size_t index);   /* clause of ISO 8559-1:2017, "5.3.20", or "" */
IM2FIT_API size_t im2fit_garment_count(void);           /* number of garments */
IM2FIT_API const char* im2fit_garment_id(size_t index); /* "t_shirt" */
IM2FIT_API const char* im2fit_fit_name(int verdict);    /* "tight" */
IM2FIT_API const char* im2fit_rig_node_name(int node);  /* "left_upper_arm" */
IM2FIT_API int im2fit_rig_node_parent(int node);        /* the parent node; -1: of node 0, or out of range */
/* "Step back" for bit 1, TOO_NEAR: at most six words, to show or speak. `language` as for im2fit_garment_name. UTF-8.
 * If several codes are set, show only the first of this list: NO_PERSON, TURN_ROUND, TURN_SLOWER, WALK_ROUND,
 * SEVERAL_PEOPLE, TOO_NEAR, TOO_FAR, HEAD_CUT, FEET_CUT, SIDE_CUT, STEP_TO_THE_MIDDLE, DEPTH_MISSING,
 * CALIBRATION_POSE, NOT_FRONTAL, NOT_UPRIGHT, ARMS_CLOSE, MOVING, TOO_NOISY, FLOOR_BENT, OUT_OF_POPULATION, TURN_ON,
 * FEET_RAISED, HEAD_UNSEEN, CLOTHED. */
IM2FIT_API const char* im2fit_guidance_text(int bit, const char* language);
/* "T-shirt". `language` is "en", "de", "es", "fr" or "zh"; NULL for others. UTF-8. */
IM2FIT_API const char* im2fit_garment_name(size_t index, const char* language);
/* "Thigh girth". `language` as for im2fit_garment_name. UTF-8. */
IM2FIT_API const char* im2fit_tape_name(size_t index, const char* language);

#ifdef __cplusplus
}
#endif
/* NOLINTEND(readability-identifier-naming) */

#endif
