/* SPDX-License-Identifier: Apache-2.0
 * Measures the person of a camera, a recording or a depth folder, by libim2fit-cameras.
 *   measure_source SOURCE TRACKER.i2t INDEX.i2f [ROTATE_DEG]     openni2 | usb | v4l2:/dev/video2 | me.oni | FOLDER
 */
#include <im2fit/cameras.h>
#include <stdio.h>
#include <stdlib.h>

static int failed(const char* what, const char* why) {
  fprintf(stderr, "measure_source: %s: %s\n", what, why);
  return 1;
}

/* Takes frames until MEASURED or the end of the source. Returns 0, or the error of the source or of the index. */
static int pump_until_measured(im2fit_handle* handle) {
  uint32_t shown = 0;
  for (;;) {
    const int status = im2fit_pump(handle, 1000);
    if (status == IM2FIT_ERROR_END_OF_STREAM) return IM2FIT_OK;
    if (status != IM2FIT_OK && status != IM2FIT_ERROR_TIMEOUT && status != IM2FIT_ERROR_CORRUPT) return status;
    /* A damaged frame is skipped. A damaged index ends the session: im2fit_wait reports it. */
    if (status == IM2FIT_ERROR_CORRUPT && im2fit_wait(handle, 1000) == IM2FIT_ERROR_CORRUPT) return status;
    im2fit_result result;
    if (im2fit_poll(handle, &result, sizeof result) != IM2FIT_OK || result.state == IM2FIT_STATE_MEASURED)
      return IM2FIT_OK;
    for (int bit = 0; result.guidance != shown && bit < IM2FIT_GUIDANCE_COUNT; ++bit)
      if ((result.guidance >> bit & 1U) != 0) fprintf(stderr, "%s\n", im2fit_guidance_name(bit));
    shown = result.guidance;
  }
}

int main(int argc, char** argv) {
  if (argc < 4) return fprintf(stderr, "usage: measure_source SOURCE TRACKER INDEX [ROTATE_DEG]\n"), 2;
  im2fit_cameras_options options;
  im2fit_cameras_options_init(&options, sizeof options);
  if (argc > 4) options.rotate_deg = atoi(argv[4]);
  im2fit_settings settings;
  im2fit_settings_init(&settings, sizeof settings);
  settings.tracker_path = argv[2];
  settings.index_path = argv[3];
  if (im2fit_cameras_describe(argv[1], &options, &settings) != IM2FIT_OK)
    return failed("source", im2fit_cameras_error());
  im2fit_handle* handle = NULL;
  if (im2fit_open(&settings, &handle) != IM2FIT_OK) return failed("open", im2fit_last_error(NULL));
  if (im2fit_cameras_use(handle, &options) != IM2FIT_OK || im2fit_attach(handle, argv[1]) != IM2FIT_OK)
    return failed("source", im2fit_cameras_error());
  const int pumped = pump_until_measured(handle);
  if (pumped != IM2FIT_OK)
    return failed("source", pumped == IM2FIT_ERROR_CORRUPT ? im2fit_last_error(handle) : im2fit_cameras_error());

  im2fit_result result;
  if (im2fit_finish(handle) != IM2FIT_OK) return failed("finish", im2fit_last_error(handle));
  if (im2fit_poll(handle, &result, sizeof result) != IM2FIT_OK) return failed("poll", im2fit_last_error(NULL));
  printf("%s, %d frames used\n", im2fit_state_name(result.state), (int)result.frames_used);
  for (int i = 0; result.measured && i < IM2FIT_MEASUREMENT_COUNT; ++i)
    printf("%-17s %7.1f %s  [%.1f, %.1f]\n", im2fit_measurement_name(i), (double)result.measurements[i].value,
           im2fit_measurement_unit(i), (double)result.measurements[i].low, (double)result.measurements[i].high);
  im2fit_close(handle);
  return result.measured ? 0 : 3;
}
