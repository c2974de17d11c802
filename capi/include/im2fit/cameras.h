/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Cameras, recordings and depth folders for im2fit.h: libim2fit-cameras, a library of its own, because it needs what
 * devices need (OpenNI2, libusb, libpng, libdeflate, yaml-cpp) and libim2fit needs nothing.
 *
 *   im2fit_settings settings;
 *   im2fit_settings_init(&settings, sizeof settings);
 *   settings.tracker_path = "tracker.i2t";
 *   settings.index_path = "index.i2f";
 *   if (im2fit_cameras_describe("me.oni", NULL, &settings) != IM2FIT_OK) puts(im2fit_cameras_error());
 *   im2fit_open(&settings, &handle);
 *   im2fit_cameras_use(handle, NULL);
 *   if (im2fit_attach(handle, "me.oni") != IM2FIT_OK) puts(im2fit_cameras_error());
 *   while (im2fit_pump(handle, 1000) == IM2FIT_OK) {           TIMEOUT and CORRUPT: call again
 *     im2fit_poll(handle, &result, sizeof result);             show result.guidance to the person
 *     if (result.state == IM2FIT_STATE_MEASURED) break;
 *   }
 *   im2fit_finish(handle);
 *
 * A URI is what the program im2fit takes as SOURCE:
 *   openni2[:URI]                    a camera of OpenNI2, the first one without URI
 *   usb[:SERIAL]                     a Kinect for Xbox 360 over USB
 *   v4l2:/dev/videoN[?key=value...]  a V4L2 depth camera (docs/cameras)
 *   PATH.oni                         a recording; FILE.oni.yaml beside it has its calibration
 *   FOLDER                           16-bit PNG or PGM and camera.yaml
 * What this build was made without is UNSUPPORTED. Which cameras are there: `im2fit devices`.
 *
 * The rules of im2fit.h hold. A source gives the same bits as its frames pushed by im2fit_push, and where a camera
 * feels gravity, or a recording says where down is, as those pushed with it by im2fit_push_frame. A camera that is
 * unplugged is NO_DEVICE: attach it again. While a handle uses this library, the library must stay loaded.
 */
#ifndef IM2FIT_CAMERAS_H
#define IM2FIT_CAMERAS_H

#include <im2fit/im2fit.h>

/* NOLINTBEGIN(readability-identifier-naming): C's names, with the library's prefix */
#ifdef __cplusplus
extern "C" {
#endif

typedef struct im2fit_cameras_options {
  size_t struct_size;           /* written by im2fit_cameras_options_init */
  const char* calibration_path; /* a camera's YAML (ROS, OpenCV) that overrides the source's own; NULL: none */
  int32_t rotate_deg;           /* how the camera is mounted: 0, 90, 180, 270; -1: what the recording says, else 0 */
  int32_t width; /* 640 x 480: wanted of a camera, before it is turned upright; the nearest mode is taken */
  int32_t height;
  float unit_mm; /* 1: of a depth folder's pixels; other sources know theirs */
} im2fit_cameras_options;

/* Fills in the defaults above. `struct_size` is sizeof(im2fit_cameras_options) as the caller sees it. */
IM2FIT_API void im2fit_cameras_options_init(im2fit_cameras_options* options, size_t struct_size);

/* Opens `uri`, looks, and closes it: what im2fit_open must know of it goes into settings->width, height, fx, fy, cx,
 * cy, sensor (0 where the camera is not known) and live (1 for cameras). `options` NULL: the defaults. Settings are
 * not touched after a failure. */
IM2FIT_API int im2fit_cameras_describe(const char* uri, const im2fit_cameras_options* options,
                                       im2fit_settings* settings);

/* From now on im2fit_attach(handle, uri) opens the URIs above: an im2fit_set_opener. `options` NULL: the defaults;
 * else they stay the caller's and must be there until im2fit_close or another opener, and are read by each
 * im2fit_attach. A source of another size than the handle's is INVALID_ARGUMENT, of im2fit_pump. */
IM2FIT_API int im2fit_cameras_use(im2fit_handle* handle, const im2fit_cameras_options* options);

/* What the latest call of the calling thread that failed here failed with, in one line, be it im2fit_attach or
 * im2fit_pump of a handle that uses this library; "" when none has. im2fit_last_error has the status alone. */
IM2FIT_API const char* im2fit_cameras_error(void);

#ifdef __cplusplus
}
#endif
/* NOLINTEND(readability-identifier-naming) */

#endif
