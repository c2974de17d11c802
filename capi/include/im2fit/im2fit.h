/* SPDX-License-Identifier: Apache-2.0 */
/*
 * im2fit: a person before one depth camera is measured, on this machine alone.
 *
 *   im2fit_settings settings;
 *   im2fit_settings_init(&settings, sizeof settings);
 *   settings.tracker_path = "tracker.i2t";
 *   settings.index_path = "index.i2f";
 *   settings.width = 480; settings.height = 640;               upright pixels
 *   settings.fx = settings.fy = 575.8f; settings.cx = 239.5f; settings.cy = 319.5f;
 *   im2fit_handle* handle;
 *   if (im2fit_open(&settings, &handle) != IM2FIT_OK) puts(im2fit_last_error(NULL));
 *   while (next_frame(depth)) {
 *     im2fit_push(handle, depth, 480, 640, 0, sequence++, time_ns);
 *     im2fit_poll(handle, &result, sizeof result);             show result.guidance to the person
 *     if (result.state == IM2FIT_STATE_MEASURED) break;
 *   }
 *   im2fit_finish(handle);                                     measures with fewer frames, if enough
 *   im2fit_close(handle);
 *
 * Rules that hold for every function:
 *   - Status codes are 0 for success and negative otherwise; im2fit_last_error says in one line what is wrong.
 *   - Memory is the caller's, except the handle. Strings returned are the library's and constant.
 *   - Paths and URIs are UTF-8, ended by a zero byte. Lengths are millimetres, masses kilograms, angles degrees.
 *   - Camera axes: x right, y down, z forward, of the upright picture. Left and right are the person's own.
 *   - fork(): a handle is of the process that opened it. In a child every function but im2fit_close refuses it with
 *     IM2FIT_ERROR_FORKED, and im2fit_close leaves camera and threads to the parent.
 *   - Threads: one thread at a time may use a handle, but im2fit_poll may be called from any thread at any time
 *     before im2fit_close. Different handles are independent.
 *   - No function throws, prints or ends the program. Nothing allocates between im2fit_open and im2fit_close, except
 *     where stated.
 *   - The same files and frames give the same results, bit for bit, on every supported machine (live = 0).
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

typedef struct im2fit_handle im2fit_handle; /* one camera, one person at a time */

/* ---- Status ---------------------------------------------------------------------------------------------------- */

enum {
  IM2FIT_OK = 0,
  IM2FIT_ERROR_INVALID_ARGUMENT = -1, /* NULL, out of range, wrong size, not now */
  IM2FIT_ERROR_NOT_FOUND = -2,        /* no such file or entry */
  IM2FIT_ERROR_IO = -3,               /* the operating system refused */
  IM2FIT_ERROR_CORRUPT = -4,          /* a file or frame is damaged or foreign */
  IM2FIT_ERROR_UNSUPPORTED = -5,      /* files that do not fit together or this version */
  IM2FIT_ERROR_NO_DEVICE = -6,        /* the source is lost */
  IM2FIT_ERROR_TIMEOUT = -7,          /* no frame in time: call again */
  IM2FIT_ERROR_END_OF_STREAM = -8,    /* the source has no more frames */
  IM2FIT_ERROR_NO_MEMORY = -9,
  IM2FIT_ERROR_NOT_MEASURED = -10, /* there is no answer yet */
  IM2FIT_ERROR_TOO_SMALL = -11,    /* the buffer; the needed count is written */
  IM2FIT_ERROR_INTERNAL = -12,
  IM2FIT_ERROR_FORKED = -13 /* the handle was opened before fork(), in the parent process: open one of your own */
};

/* "1.0.0": of the library in use, which may be newer than this header. */
IM2FIT_API const char* im2fit_version(void);

/* A short name, "no_device"; "unknown" for other numbers. */
IM2FIT_API const char* im2fit_status_name(int status);

/* What the latest call on this handle failed with, or "" when it did not; valid until the next call on the handle.
 * im2fit_poll, which any thread may call, leaves it alone. With NULL: the last failure of any call of the calling
 * thread, that of im2fit_open and im2fit_poll among them; a success does not empty it. */
IM2FIT_API const char* im2fit_last_error(const im2fit_handle* handle);

/* ---- Opening --------------------------------------------------------------------------------------------------- */

/* Every failure is also reported here, on the thread of the failing call. The text is valid during the call. */
typedef void (*im2fit_log_fn)(void* user, int status, const char* text);

/* Where a file is, for those that have no path: an asset inside an APK, a file read from elsewhere. */
enum { IM2FIT_DATA_PATH = 0, IM2FIT_DATA_MEMORY = 1, IM2FIT_DATA_FD = 2 };
typedef struct im2fit_data {
  int32_t kind;   /* IM2FIT_DATA_...; PATH: where the settings' field of that name says, what follows is not read */
  int32_t fd;     /* FD: open for reading, seekable; stays the caller's, who may close it after im2fit_open */
  int64_t offset; /* FD: bytes before the file; an asset must be stored, not deflated */
  const void* bytes; /* MEMORY: copied by im2fit_open */
  size_t size;       /* of the file in bytes; MEMORY and FD. Copied; a path's file of more than 64 MiB is mapped */
} im2fit_data;

typedef struct im2fit_settings {
  size_t struct_size;         /* written by im2fit_settings_init */
  const char* tracker_path;   /* .i2t, required */
  const char* index_path;     /* .i2f, required */
  const char* body_path;      /* .i2b, or NULL: no im2fit_body_mesh, and features alone answer (no shape is fitted) */
  const char* men_chart_path; /* .csv size charts (docs/result.md); both or neither. NULL: EN 13402-3, built in */
  const char* women_chart_path;
  int32_t width; /* pixels of upright frames, 1..2048 */
  int32_t height;
  float fx, fy, cx, cy;    /* pixels; the depth camera's own, not the colour camera's. Centre of pixel 0 is 0 */
  int32_t frames_wanted;   /* 30: accepted frames until MEASURED, 1..1000; of each side with `turn` */
  int32_t frames_min;      /* 5: fewest that im2fit_finish measures with, 1..frames_wanted */
  int32_t calibration_psi; /* 0: none. 1: ask for raised arms first. Flags are 0 or 1, other values are refused */
  int32_t live;            /* 0: im2fit_push waits when behind. 1: drops the oldest frame and counts it */
  int32_t single_thread;   /* 0: two threads. 1: all work inside im2fit_push */
  int32_t pool_frames;     /* 8: frames held, 3..64, three bytes a pixel each */
  im2fit_log_fn log;       /* NULL: none */
  void* log_user;
  int32_t user_id;  /* 0: whoever stands right first. Else only the person with this im2fit_result.user_id */
  int32_t turn;     /* 0: the front is measured. 1: then the person is asked to turn round, and the back as well */
  int32_t clothing; /* IM2FIT_CLOTHING_...: what the person wears. 0: estimated from the frames */
  int32_t sensor;   /* IM2FIT_SENSOR_...: how the camera senses depth. 0: judged from the frames */
  im2fit_data tracker_data; /* instead of the paths above */
  im2fit_data index_data;
  im2fit_data body_data;
  const char* calibration_site_path; /* .i2c, by which every answer is corrected (docs/calibration.md), or NULL */
  im2fit_data calibration_site_data; /* instead of the path */
} im2fit_settings;

/* How a camera senses depth, where the caller knows: people's outlines come out differently. */
enum {
  IM2FIT_SENSOR_UNKNOWN = 0,          /* judged from the frames: docs/cameras says where that is not enough */
  IM2FIT_SENSOR_STRUCTURED_LIGHT = 1, /* Kinect for Xbox 360, Xtion, Astra */
  IM2FIT_SENSOR_TIME_OF_FLIGHT = 2    /* Kinect v2, Azure Kinect */
};

/* What the person wears, where the caller knows. */
enum {
  IM2FIT_CLOTHING_UNKNOWN = 0, /* estimated, given body_path: intervals are as wide as what is seen makes them */
  IM2FIT_CLOTHING_BARE = 1,    /* underwear or close-fitting sportswear; GUIDANCE_CLOTHED when it does not look so */
  IM2FIT_CLOTHING_DRESSED = 2  /* the body underneath, with wider intervals; needs body_path */
};

/* Fills in the defaults above, NULL and 0 elsewhere. `struct_size` is sizeof(im2fit_settings) as the caller sees it.
 */
IM2FIT_API void im2fit_settings_init(im2fit_settings* settings, size_t struct_size);

/* Loads the files, allocates everything, starts the threads. *handle is NULL after a failure. */
IM2FIT_API int im2fit_open(const im2fit_settings* settings, im2fit_handle** handle);

/* Stops the threads and frees everything, from any state; frames in the pipeline are given up. NULL is fine. */
IM2FIT_API void im2fit_close(im2fit_handle* handle);

/* ---- Frames ---------------------------------------------------------------------------------------------------- */

/* Copies one upright depth frame: 16-bit millimetres, 0 where there is no data, `stride` values from row to row
 * (0: width). `sequence` and `time_ns` (monotonic) are the camera's, for counting gaps; 0 when it has none.
 * Errors: INVALID_ARGUMENT for another size than the settings', or after im2fit_finish; CORRUPT as im2fit_finish. */
IM2FIT_API int im2fit_push(im2fit_handle* handle, const uint16_t* depth_mm, int32_t width, int32_t height,
                           size_t stride, uint64_t sequence, int64_t time_ns);

/* How a frame's samples are stored. */
enum {
  IM2FIT_FORMAT_U16 = 0,     /* 16-bit whole numbers of `unit_mm`; 0: no data */
  IM2FIT_FORMAT_DEPTH16 = 1, /* Android's ImageFormat.DEPTH16: 13 bits of mm under 3 bits of confidence */
  IM2FIT_FORMAT_F32 = 2      /* 32-bit floats, metres; NaN, infinite, zero and negative: no data */
};

/* A frame as cameras and phones deliver it, before it is upright. Set what is known, leave the rest as
 * im2fit_frame_init made it. Beyond 65535 mm there is no data. */
typedef struct im2fit_frame {
  size_t struct_size; /* written by im2fit_frame_init */
  const void* pixels; /* rows from the top, samples of the machine's byte order, aligned as such */
  int32_t format;     /* IM2FIT_FORMAT_... */
  int32_t width;      /* as delivered: turned by rotate_deg it must be the settings' size */
  int32_t height;
  int32_t rotate_deg;        /* 0, 90, 180, 270: clockwise, what makes the picture upright */
  size_t row_bytes;          /* from row to row, a multiple of the sample's; 0: no padding */
  float unit_mm;             /* 1: of U16, above 0 to 1000 */
  int32_t confidence_min;    /* 0: all are taken. DEPTH16: sevenths of sure, 0..7. Else of the plane below, 0..255 */
  const uint8_t* confidence; /* a byte a sample, of U16 and F32: less than confidence_min is no data. NULL: none */
  size_t confidence_row_bytes; /* 0: width */
  /* The intrinsics of this frame, in pixels of the frame as delivered; all 0: the settings'. Those of the first frame
   * after im2fit_open or im2fit_reset are the session's; a later frame with others is resampled to them (nearest
   * sample). A session takes frames by this function or by im2fit_push, not by both. */
  float fx, fy, cx, cy;
  uint64_t sequence; /* as im2fit_push */
  int64_t time_ns;
  int64_t device_us; /* the device's own clock; -1: it has none */
  /* Which way gravity pulls, of any length, in the axes of the frame as delivered: x right, y down, z forward. All 0:
   * not known, and then the latest told holds until im2fit_reset. Android's TYPE_GRAVITY points up: negate it. Where
   * no floor is seen it says what is upright. */
  float down_x, down_y, down_z;
  float reserved; /* 0 */
  /* The lens, where the picture is not undistorted yet: Brown and Conrady's, radial and tangential, as OpenCV has it.
   * Android's LENS_DISTORTION is k1 k2 k3 p1 p2 in this order. All 0: none. Undone through a table (nearest sample),
   * made when lens, intrinsics or rotation differ from the frame's before; the first one allocates. */
  float k1, k2, k3, p1, p2;
  float reserved2; /* 0 */
  /* Where the camera is, when it is held in the hand or moves, as the platform tracks it: turn_x .. turn_w is the
   * unit quaternion that takes a direction in the axes of the frame as delivered to those of a place at rest, and
   * x_mm .. z_mm where the camera is there (0: taken to turn about itself). All 0: not known, and the frame is taken
   * as it is. The frame becomes what the first one told was a view of (nearest sample); after a turn of more than 10
   * degrees or a step of more than 150 mm it begins a view of its own. ARKit and OpenGL have y up and z backwards:
   * negate y and z of the axes on the camera's side, which makes (x, y, z, w) into (w, z, -y, -x). The first told
   * allocates. */
  float turn_x, turn_y, turn_z, turn_w;
  float x_mm, y_mm, z_mm;
  float reserved3; /* 0 */
} im2fit_frame;

/* Fills in the defaults above, NULL and 0 elsewhere. `struct_size` is sizeof(im2fit_frame) as the caller sees it. */
IM2FIT_API void im2fit_frame_init(im2fit_frame* frame, size_t struct_size);

/* im2fit_push for such a frame: made millimetres, upright, and pushed. One scene in each of the three formats gives
 * the same bits. INVALID_ARGUMENT names the field that is out of range; UNSUPPORTED for a struct_size that fits no
 * version. Else as im2fit_push. */
IM2FIT_API int im2fit_push_frame(im2fit_handle* handle, const im2fit_frame* frame);

/* Waits until every frame pushed has been processed, so that im2fit_poll speaks of all of them. TIMEOUT after
 * `timeout_ms`; negative: no limit. */
IM2FIT_API int im2fit_wait(im2fit_handle* handle, int32_t timeout_ms);

/* No more frames: waits for those in the pipeline and measures with what there is. Fine to call twice. CORRUPT: the
 * index is damaged where it was read (a large one is checked where it is read, not when it is opened). */
IM2FIT_API int im2fit_finish(im2fit_handle* handle);

/* A new person: forgets everything seen. After im2fit_finish or between frames. */
IM2FIT_API int im2fit_reset(im2fit_handle* handle);

/* The next person, after IM2FIT_STATE_MEASURED: frames are processed again, and the answer stands until the person
 * measured has left the picture for half a second; then a new session begins by itself (im2fit_result.session counts
 * it). Before the measurement: begins anew at once. The floor and the ids are kept, unlike with im2fit_reset. */
IM2FIT_API int im2fit_next(im2fit_handle* handle);

/* From the next frame on only the person of this user_id; 0: whoever stands right first, as at the start.
 * Another than before begins anew. INVALID_ARGUMENT for a negative id. */
IM2FIT_API int im2fit_select_user(im2fit_handle* handle, int32_t user_id);

/* ---- Sources by URI (optional) --------------------------------------------------------------------------------- */

/* One opened source, filled in by an opener. */
typedef struct im2fit_source {
  void* user;
  /* Waits up to `timeout_ms` for a frame and writes it, width x height of the settings, rows without padding.
   * Returns IM2FIT_OK, TIMEOUT, END_OF_STREAM, CORRUPT (this frame is left out), NO_DEVICE or IO. */
  int (*next)(void* user, uint16_t* depth_mm, int32_t width, int32_t height, int32_t timeout_ms, uint64_t* sequence,
              int64_t* time_ns);
  void (*close)(void* user); /* called once; may be NULL */
} im2fit_source;

/* Opens `uri` into *source. Returns IM2FIT_OK or an error, then *source is not used. What is no status of this header
 * (42, say) comes out of im2fit_attach and im2fit_pump as IO, with a text that names the number. */
typedef int (*im2fit_opener_fn)(void* opener_user, const char* uri, im2fit_source* source);

/* Who opens URIs for this handle; NULL: none. The library itself knows no cameras: libim2fit-cameras has an opener
 * for them (im2fit/cameras.h). */
IM2FIT_API int im2fit_set_opener(im2fit_handle* handle, im2fit_opener_fn opener, void* opener_user);

/* Which way gravity pulls, for the frame that the source of this `user` has just given: to `down`, of any length but
 * 0, in that frame's axes (x right, y down, z forward). Returns 1, or 0 where it is not known: then what was known
 * before stands. Called by im2fit_pump after each frame. */
typedef int (*im2fit_down_fn)(void* user, float down[3]);

/* For the sources that the opener opens from now on; NULL, as at first: they do not feel gravity. What it is good
 * for: im2fit_frame.down_x. Since 0.2. */
IM2FIT_API int im2fit_set_opener_down(im2fit_handle* handle, im2fit_down_fn down);

/* Opens `uri` through the opener, after closing what was attached. UNSUPPORTED without an opener. Allocates. */
IM2FIT_API int im2fit_attach(im2fit_handle* handle, const char* uri);

/* Takes one frame from the attached source and pushes it. TIMEOUT, CORRUPT: call again. END_OF_STREAM, NO_DEVICE:
 * call im2fit_finish. INVALID_ARGUMENT when nothing is attached. */
IM2FIT_API int im2fit_pump(im2fit_handle* handle, int32_t timeout_ms);

/* Closes the attached source, if any; im2fit_close does so too. */
IM2FIT_API int im2fit_detach(im2fit_handle* handle);

/* ---- The models a handle was opened with ----------------------------------------------------------------------- */

typedef struct im2fit_models {
  const char* made_by;     /* the index: by which program, from what; the handle's, constant */
  uint32_t people;         /* whom the index was made of */
  uint32_t captures;       /* of these people, in the index */
  uint32_t tracker_key;    /* names the tracker; an index made with another is refused when opened */
  int32_t has_body;        /* 1: body data was given, so that there are meshes, tape, avatars and garments */
  int32_t answers_shape;   /* 1: a shape is fitted to the depth as well; 0: the body data is not what the index was */
                           /* made with, or there is none, and answers are less good */
  int32_t answers_turned;  /* 1: the index knows people from behind, so that settings.turn is of use */
  int32_t answers_clothed; /* 1: it knows people in clothes */
  int32_t site_corrected;  /* 1: answers are corrected for the site (settings.calibration_site_path) */
} im2fit_models;

/* What the models are and what they can answer: for a support page, or to refuse a pack that is not enough.
 * `struct_size` is sizeof *models as the caller sees it. No allocation. */
IM2FIT_API int im2fit_get_models(im2fit_handle* handle, im2fit_models* models, size_t struct_size);

/* ---- Results --------------------------------------------------------------------------------------------------- */

enum {
  IM2FIT_STATE_SEARCHING = 0, /* no person yet */
  IM2FIT_STATE_USER_FOUND,    /* a person, not yet as needed: see the guidance */
  IM2FIT_STATE_CALIBRATING,   /* waiting for the calibration pose */
  IM2FIT_STATE_TRACKING,      /* accumulating frames */
  IM2FIT_STATE_MEASURED,      /* the answer stands until im2fit_reset; further frames are ignored */
  IM2FIT_STATE_LOST,          /* gone; begins again when found, a limited number of times until im2fit_reset */
  /* settings.turn: the front is measured (im2fit_result.front_measured), the back is being accumulated. MEASURED
   * follows: with both sides; or with the front alone when the person leaves or does not turn within 450 frames. */
  IM2FIT_STATE_TURNING
};

/* What is needed of the person or the scene: bits of im2fit_result.guidance. */
enum {
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
  IM2FIT_GUIDANCE_TURN_ROUND = 1 << 13,       /* show the back; to be shown before all other guidance */
  IM2FIT_GUIDANCE_CLOTHED = 1 << 14           /* measured, but dressed where settings.clothing said bare */
};
#define IM2FIT_GUIDANCE_COUNT 15

/* The person's own arms. */
enum { IM2FIT_ARM_LEFT = 1 << 0, IM2FIT_ARM_RIGHT = 1 << 1 };

/* Which side of the person the camera sees. */
enum {
  IM2FIT_VIEW_UNKNOWN = 0,
  IM2FIT_VIEW_FRONT,
  IM2FIT_VIEW_BACK,
  IM2FIT_VIEW_SIDE /* turned too far for either */
};

/* What an answer rests on. */
enum {
  IM2FIT_VIEWS_NONE = 0, /* no answer */
  IM2FIT_VIEWS_FRONT,
  IM2FIT_VIEWS_FRONT_AND_BACK
};

/* Of the naked body, relaxed standing; girths round the convex hull of the section (docs/result.md). */
enum {
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
};
#define IM2FIT_MEASUREMENT_COUNT 11

/* HE NE TO LS RS LE RE LA RA LH RH LK RK LF RF: head, neck, torso, then left and right shoulder, elbow, hand, hip,
 * knee, foot. */
#define IM2FIT_JOINT_COUNT 15

typedef struct im2fit_estimate {
  float value; /* mm, kg for the weight, years for the age */
  float low;   /* 95 % interval */
  float high;
} im2fit_estimate;

typedef struct im2fit_joint {
  float x, y, z;    /* mm, camera axes */
  float confidence; /* 0..1: chance of being within 50 mm; below 0.25 the joint is inferred, not seen */
} im2fit_joint;

/* A person in view: pixels of the upright picture, inclusive; mm, camera axes. */
typedef struct im2fit_user {
  int32_t id; /* >= 1 */
  int32_t left, top, right, bottom;
  float x, y, z; /* the middle of what is seen */
} im2fit_user;
#define IM2FIT_USER_COUNT_MAX 8
#define IM2FIT_AGE_BAND_COUNT 4

typedef struct im2fit_result {
  int32_t state;          /* IM2FIT_STATE_... */
  uint32_t guidance;      /* of the latest frame; once measured 0 or CLOTHED */
  uint32_t guidance_seen; /* of all frames */
  int32_t has_joints;     /* 1: `joints` holds the latest frame's, or once measured the mean behind the answer */
  uint64_t frames_seen;   /* until the measurement */
  uint64_t frames_used;
  uint64_t frames_dropped;
  uint64_t sequence_gaps;
  uint64_t sequence_repeats;
  uint64_t time_reversals;
  im2fit_joint joints[IM2FIT_JOINT_COUNT];
  int32_t measured; /* 1: what follows is valid; with front_measured it is, too, but preliminary */
  float female;     /* probability */
  im2fit_estimate measurements[IM2FIT_MEASUREMENT_COUNT];
  float paper[IM2FIT_MEASUREMENT_COUNT]; /* the published method's own, NaN where it has none */
  uint32_t index_entry;                  /* the stored body nearest to the answer */
  float index_distance;
  int32_t user_id; /* whose joints and guidance these are: >= 1, never given to two people; 0: no person is in view */
  int32_t view;    /* IM2FIT_VIEW_..., of the latest frame */
  uint32_t joints_inferred; /* bit per joint of display_joints: not seen, held by the skeleton where it was last */
  uint32_t session;         /* counts the sessions begun after im2fit_next, from 0 */
  /* The latest frame's, to draw, once measured too; zero confidence without has_joints. Smoothed: a joint at rest is
   * shown 0.11 s late, at 1 m/s 0.02 s. `joints` is not. */
  im2fit_joint display_joints[IM2FIT_JOINT_COUNT];
  int32_t user_count; /* all people in view, nearest first */
  im2fit_user users[IM2FIT_USER_COUNT_MAX];
  int32_t front_measured; /* 1: from TURNING on; until `measured` the values are those of the front alone */
  int32_t views;          /* IM2FIT_VIEWS_..., of the answer */
  uint32_t frames_back;   /* of frames_used: those of the back */
  im2fit_estimate age;    /* years: median and 95 % of the people in the index who look alike */
  float age_bands[IM2FIT_AGE_BAND_COUNT]; /* probabilities of 18-25, 25-45, 45-65, 65-75 years */
  uint32_t arms_close;        /* IM2FIT_ARM_... or-ed: which of the person's arms ARMS_CLOSE of `guidance` is about */
  float clothing_probability; /* of being dressed, by the frames alone; NaN: not estimated */
  float clothing_ease_mm;     /* expected, of cloth off the trunk's skin; NaN: not estimated */
} im2fit_result;

/* A consistent copy of the latest state; never waits for the threads at work. `struct_size` is sizeof *result: a
 * caller built with an older header gets the fields it knows. */
IM2FIT_API int im2fit_poll(const im2fit_handle* handle, im2fit_result* result, size_t struct_size);

typedef struct im2fit_size {
  char name[32];     /* "M"; "<XS" and ">3XL" outside the chart */
  float probability; /* they sum to 1 */
} im2fit_size;

/* The sizes of the chart, small to large, with their probabilities. *count gets the number of sizes, *best (may be
 * NULL) the index of the likeliest. NOT_MEASURED, or TOO_SMALL when `capacity` is less than *count (ask with 0).
 * Allocates. */
IM2FIT_API int im2fit_sizes(im2fit_handle* handle, im2fit_size* sizes, size_t capacity, size_t* count, size_t* best);

/* Whether a measurement of the tape has a value for a person. */
enum {
  IM2FIT_TAPE_MEASURED = 0,
  IM2FIT_TAPE_REFUSED, /* never measured: a depth camera, or the body model, does not show it */
  IM2FIT_TAPE_ABSENT   /* not of this body: it has no such section */
};

typedef struct im2fit_tape_value {
  int32_t status;     /* IM2FIT_TAPE_... */
  float value;        /* mm, kg of weight; NaN unless MEASURED */
  float low, high;    /* 95 % interval; NaN unless MEASURED */
  const char* reason; /* why there is no value, in a sentence; NULL when MEASURED. The library's, constant */
} im2fit_tape_value;

/* The tape (docs/tape.md): what the one body measures by each of `id_count` definitions, named by the ids of
 * im2fit_tape_id; with ids = NULL the first `id_count` of that list. values[i] belongs to ids[i]; `value_size` is
 * sizeof(im2fit_tape_value) as the caller sees it, and the distance from value to value. The eleven of
 * im2fit_result.measurements are here as the mesh has them, with the same intervals. NOT_FOUND names an unknown id;
 * then, as after any error, no value is written. Needs settings.body_path. As im2fit_body_mesh. */
IM2FIT_API int im2fit_tape(im2fit_handle* handle, const char* const* ids, size_t id_count, im2fit_tape_value* values,
                           size_t value_size);

/* The person as a mesh in the measured pose, of the one body that measures what `measurements` says: mm, x the
 * person's left, y up, z out of the face, the soles on y = 0. `vertices`: x y z each, so that `vertex_capacity`
 * vertices are 3 x vertex_capacity floats; `triangles`: three vertex indices each, counter-clockwise from outside,
 * 3 x triangle_capacity numbers. The counts needed, of vertices and triangles, are always written; NULL buffers ask
 * for the counts. Needs settings.body_path. Allocates; the first of these functions takes a few hundredths
 * of a second. */
IM2FIT_API int im2fit_body_mesh(im2fit_handle* handle, float* vertices, size_t vertex_capacity, size_t* vertex_count,
                                int32_t* triangles, size_t triangle_capacity, size_t* triangle_count);

/* How far that body's own measurements are off `measurements`, by id; mm, and kg of weight. Below a millimetre,
 * unless no body measures all that is reported: then say so where more than 2 mm of a girth matter. As
 * im2fit_body_mesh. */
IM2FIT_API int im2fit_body_residual(im2fit_handle* handle, float residual[IM2FIT_MEASUREMENT_COUNT]);

/* The result as JSON (docs/result.md), UTF-8 with a zero byte behind it, whether measured or not. *length gets the
 * bytes without that zero; TOO_SMALL when `capacity` is not more than it (ask with 0). The body, and what follows
 * from it, is left out without settings.body_path. UNSUPPORTED: a library built without it. Allocates. */
IM2FIT_API int im2fit_result_json(im2fit_handle* handle, char* text, size_t capacity, size_t* length);

enum { IM2FIT_AVATAR_GLB = 0, IM2FIT_AVATAR_OBJ = 1, IM2FIT_AVATAR_BVH = 2 };

/* The person as a file other programs read (docs/formats-body.md): the bytes of a .glb, .obj or .bvh. *size gets
 * their number, TOO_SMALL when `capacity` is less (ask with 0). Errors and needs as im2fit_body_mesh; UNSUPPORTED
 * also from a library built without it. The .obj has texture coordinates but names no material library, as bytes have
 * no file beside them; its texture is the image in the .glb. Allocates. */
IM2FIT_API int im2fit_avatar(im2fit_handle* handle, int32_t format, void* bytes, size_t capacity, size_t* size);

/* How the nodes 0 to 18 of an avatar's .glb, im2fit_avatar's or im2fit_dressed_avatar's, are to stand so that it does
 * what the person does: in the file's order and axes (y up, metres, the hips above the origin, the lower foot on
 * y = 0). Set node 0's translation and every node's rotation; other translations stay as they are. */
#define IM2FIT_RIG_NODE_COUNT 19
typedef struct im2fit_rig {
  float root_m[3];                           /* x y z, translation of node 0 */
  float rotations[IM2FIT_RIG_NODE_COUNT][4]; /* unit quaternions x y z w, relative to the node's parent */
  int32_t user_id;                           /* whose joints these are */
  uint32_t joints_inferred;                  /* as im2fit_result's: where the pose is a guess */
} im2fit_rig;

/* The rig of the latest frame, by im2fit_result.display_joints, on the body of whoever was measured: so from MEASURED
 * on, and moving once im2fit_next lets frames in again, until the next session begins. NOT_FOUND: no person is
 * followed in the latest frame. `struct_size` is sizeof *rig as the caller sees it. As im2fit_body_mesh, and
 * UNSUPPORTED as im2fit_avatar; allocates the first time for each person. */
IM2FIT_API int im2fit_live_rig(im2fit_handle* handle, im2fit_rig* rig, size_t struct_size);

/* ---- Garments (docs/garments.md) ------------------------------------------------------------------------------- */

/* How a garment sits at a place. */
enum {
  IM2FIT_FIT_TIGHT = 0, /* it binds */
  IM2FIT_FIT_SNUG,      /* closer than meant */
  IM2FIT_FIT_GOOD,      /* as meant */
  IM2FIT_FIT_LOOSE      /* wider than meant */
};

typedef struct im2fit_region_fit {
  const char* name;      /* "chest"; the library's, constant */
  float ease_mm;         /* finished girth less the body's */
  float low_mm, high_mm; /* 95 % interval */
  int32_t verdict;       /* IM2FIT_FIT_..., of ease_mm */
} im2fit_region_fit;
#define IM2FIT_REGION_COUNT_MAX 8

typedef struct im2fit_size_fit {
  char name[32];        /* "M" */
  float cost;           /* 0: as meant everywhere; comparable between sizes of one garment */
  int32_t region_count; /* of `regions`; the same for each size of a garment */
  im2fit_region_fit regions[IM2FIT_REGION_COUNT_MAX];
} im2fit_size_fit;

/* How each size of the chart for the person's sex would sit, small to large, in the garment of an id of
 * im2fit_garment_id. `fit_size` is sizeof(im2fit_size_fit) as the caller sees it, and the distance from one to the
 * next. *count gets the number of sizes, *best (may be NULL) the index of the one to buy; none fits when that one is
 * tight somewhere, or loose everywhere. NOT_FOUND names an unknown garment; TOO_SMALL when `capacity` is less than
 * *count (ask with 0). As im2fit_tape. */
IM2FIT_API int im2fit_garment_fit(im2fit_handle* handle, const char* garment, im2fit_size_fit* fits, size_t fit_size,
                                  size_t capacity, size_t* count, size_t* best);

typedef struct im2fit_worn {
  const char* garment; /* an id of im2fit_garment_id */
  const char* size;    /* of the chart, "M"; NULL: the best */
} im2fit_worn;
#define IM2FIT_WORN_COUNT_MAX 4

/* The person as im2fit_avatar's .glb, dressed: the garments draped on the body in the measured pose, what lies on the
 * skin first. A `worn_count` of 0: trousers and a T-shirt of the best sizes. NOT_FOUND names an unknown garment or
 * size. The latest one made is kept, so that asking with a `capacity` of 0 first costs nothing: a tenth of a second a
 * garment and some megabytes. Else as im2fit_avatar. */
IM2FIT_API int im2fit_dressed_avatar(im2fit_handle* handle, const im2fit_worn* worn, size_t worn_count, void* bytes,
                                     size_t capacity, size_t* size);

/* ---- Names, as in result.json; NULL when out of range ---------------------------------------------------------- */

IM2FIT_API const char* im2fit_state_name(int state);    /* "TRACKING" */
IM2FIT_API const char* im2fit_guidance_name(int bit);   /* 0..14: "TOO_NEAR" is bit 1 */
IM2FIT_API const char* im2fit_measurement_name(int id); /* "chest_girth" */
IM2FIT_API const char* im2fit_measurement_unit(int id); /* "mm" or "kg" */
IM2FIT_API const char* im2fit_joint_name(int joint);    /* "HE" */
IM2FIT_API const char* im2fit_view_name(int view);      /* "front" */
IM2FIT_API size_t im2fit_tape_count(void);              /* definitions of the tape; any thread, at any time */
IM2FIT_API const char* im2fit_tape_id(size_t index);    /* "thigh_girth" */
IM2FIT_API const char* im2fit_tape_unit(size_t index);  /* "mm" or "kg" */
IM2FIT_API const char* im2fit_tape_iso(size_t index);   /* "5.3.20" of ISO 8559-1:2017, or "" */
IM2FIT_API size_t im2fit_garment_count(void);           /* any thread, at any time */
IM2FIT_API const char* im2fit_garment_id(size_t index); /* "t_shirt" */
IM2FIT_API const char* im2fit_fit_name(int verdict);    /* "tight" */
IM2FIT_API const char* im2fit_rig_node_name(int node);  /* "left_upper_arm" */
IM2FIT_API int im2fit_rig_node_parent(int node);        /* a node; -1: node 0's, or out of range */
/* "T-shirt"; languages as im2fit_tape_name's. */
IM2FIT_API const char* im2fit_garment_name(size_t index, const char* language);
/* "Thigh girth"; in the language "en", "de", "es", "fr" or "zh", UTF-8. */
IM2FIT_API const char* im2fit_tape_name(size_t index, const char* language);

#ifdef __cplusplus
}
#endif
/* NOLINTEND(readability-identifier-naming) */

#endif
