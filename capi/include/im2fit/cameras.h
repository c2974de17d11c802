/* SPDX-License-Identifier: Apache-2.0 */
/*
 * libim2fit-cameras opens cameras, recordings and depth folders for im2fit.h. It is a separate library because it
 * needs OpenNI2, libusb, libpng, libdeflate, yaml-cpp, libbz2, liblz4 and libzip. libim2fit needs none of them.
 *
 *   im2fit_settings settings;
 *   im2fit_settings_init(&settings, sizeof settings);
 *   settings.tracker_path = "tracker.i2t";
 *   settings.index_path = "index.i2f";
 *   if (im2fit_cameras_describe("me.oni", NULL, &settings) != IM2FIT_OK) puts(im2fit_cameras_error());
 *   im2fit_open(&settings, &handle);
 *   im2fit_cameras_use(handle, NULL);
 *   if (im2fit_attach(handle, "me.oni") != IM2FIT_OK) puts(im2fit_cameras_error());
 *   while (im2fit_pump(handle, 1000) == IM2FIT_OK) {           TIMEOUT, damaged frame: call again
 *     im2fit_poll(handle, &result, sizeof result);             show result.guidance to the person
 *     if (result.state == IM2FIT_STATE_MEASURED) break;
 *   }
 *   im2fit_finish(handle);
 *
 * A URI has the form of SOURCE in the program im2fit:
 *   openni2[:URI]                    a camera of OpenNI2. Without URI: the first camera
 *   usb[:SERIAL]                     a Kinect for Xbox 360 over USB
 *   v4l2:/dev/videoN[?key=value...]  a V4L2 depth camera (docs/cameras)
 *   PATH.oni                         a recording. PATH.oni.yaml contains its calibration
 *   PATH.mkv, PATH.bag               a recording of an Azure Kinect or Femto, of RealSense's programs or ROS 1
 *   PATH.zip                         a folder or a phone's recording in an archive
 *   FOLDER                           a folder with 16-bit PNG or PGM files and camera.yaml
 * `im2fit devices` lists the cameras that are connected.
 *
 * Errors of im2fit_cameras_describe and im2fit_attach for a URI:
 *   NOT_FOUND         an unknown URI, or a V4L2 node, recording or folder that does not exist
 *   NO_DEVICE         the camera is not connected
 *   CORRUPT           the recording or folder is damaged
 *   IO                the operating system reported an error, for example: another program uses the camera
 *   INVALID_ARGUMENT  the options do not fit the source; the text names the option
 *   UNSUPPORTED       this build lacks this kind of source, or the camera has no usable format
 *
 * The rules of im2fit.h hold here too.
 *   - Results: a source gives bit-identical results to its frames pushed by im2fit_push.
 *   - Gravity: the direction from an accelerometer or a recording is passed to the engine. The results are then those
 *     of im2fit_push_frame with down_x.
 *   - Unplugged camera: im2fit_pump returns NO_DEVICE. Attach the camera again.
 *   - Unloading: the library must stay loaded while a handle uses it.
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
  const char* calibration_path; /* YAML (ROS, OpenCV) that replaces the source's own calibration; NULL: none */
  int32_t rotate_deg;           /* 0, 90, 180, 270: clockwise, makes the picture upright. -1: as recorded, or 0 */
  int32_t width; /* 640 x 480: preferred mode of a camera, before rotation, 1..2048. The nearest mode is used */
  int32_t height;
  float unit_mm; /* unit of a folder's pixels, above 0, up to 1000; 1: the folder's own. Only for folders */
} im2fit_cameras_options;

/* Writes the defaults above. `struct_size` is sizeof(im2fit_cameras_options) of the caller's header. */
IM2FIT_API void im2fit_cameras_options_init(im2fit_cameras_options* options, size_t struct_size);

/* Opens `uri`, reads its properties and closes it. Writes width, height, fx, fy, cx, cy, sensor (0: unknown) and live
 * (1 for cameras) of *settings, for im2fit_open. Other settings are not changed. After an error no setting is
 * changed. `options` NULL: the defaults. Allocates.
 * Errors: as listed above; UNSUPPORTED also for an unknown struct_size. */
IM2FIT_API int im2fit_cameras_describe(const char* uri, const im2fit_cameras_options* options,
                                       im2fit_settings* settings);

/* Makes im2fit_attach(handle, uri) open the URIs above. It calls im2fit_set_opener and im2fit_set_opener_down.
 * `options` NULL: the defaults. Otherwise each im2fit_attach reads *options, which must stay valid until im2fit_close
 * or until another opener is set. If the upright frames of a source have another size than the settings, im2fit_pump
 * returns INVALID_ARGUMENT.
 * Errors:
 *   INVALID_ARGUMENT  an option is out of range, or the handle is NULL
 *   UNSUPPORTED       options->struct_size is unknown
 *   FORKED            the parent process opened the handle */
IM2FIT_API int im2fit_cameras_use(im2fit_handle* handle, const im2fit_cameras_options* options);

/* The latest error of this library on the calling thread, in one line. It covers the functions above, and
 * im2fit_attach and im2fit_pump of a handle that uses this library. "" before the first error. im2fit_last_error has
 * only the status. */
IM2FIT_API const char* im2fit_cameras_error(void);

#ifdef __cplusplus
}
#endif
/* NOLINTEND(readability-identifier-naming) */

#endif
