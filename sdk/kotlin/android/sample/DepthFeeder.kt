// SPDX-License-Identifier: Apache-2.0
// A sample: a Camera2 camera that delivers DEPTH16 feeds a session. Copy it into an app. The tests compile it with stubs of
// Android's classes and run its lifecycle on them. It has not run on a phone.
package im2fit.sample

import android.content.Context
import android.graphics.ImageFormat
import android.hardware.Sensor
import android.hardware.SensorEvent
import android.hardware.SensorEventListener
import android.hardware.SensorManager
import android.hardware.camera2.CameraCaptureSession
import android.hardware.camera2.CameraCharacteristics
import android.hardware.camera2.CameraDevice
import android.hardware.camera2.CameraManager
import android.hardware.camera2.CaptureRequest
import android.media.ImageReader
import android.os.Build
import android.os.Handler
import im2fit.sdk.CameraModel
import im2fit.sdk.DepthFormat
import im2fit.sdk.DepthFrame
import im2fit.sdk.Direction
import im2fit.sdk.FitSession
import im2fit.sdk.Lens
import im2fit.sdk.Models
import im2fit.sdk.Progress
import im2fit.sdk.Settings

/** The camera was lost, refused to start, or delivered a frame that cannot be used. */
class CameraFailure(message: String, cause: Throwable? = null) : RuntimeException(message, cause)

/**
 * Opens the first back camera with DEPTH16 and calls [onProgress] after each frame, on [handler]'s thread. The app holds the
 * CAMERA permission. Call [close] from any thread. No frame is taken after it, and a camera that opens later is closed.
 *
 * @param onFailure called once at most, on [handler]'s thread. No frame follows: call [close], and tell the person
 */
class DepthFeeder(
    context: Context, models: Models, private val handler: Handler, settings: Settings = Settings(live = true),
    private val onFailure: (CameraFailure) -> Unit, private val onProgress: (Progress) -> Unit
) : AutoCloseable {
    private val cameras = context.getSystemService(Context.CAMERA_SERVICE) as CameraManager
    private val sensors = context.getSystemService(Context.SENSOR_SERVICE) as SensorManager
    private val id = cameras.cameraIdList.firstOrNull { hasDepth(cameras.getCameraCharacteristics(it)) }
        ?: throw UnsupportedOperationException("no back camera of this device delivers DEPTH16")
    private val camera = cameraOf(cameras.getCameraCharacteristics(id))
    /** For [FitSession.mask], [FitSession.finish] and the like, from any thread. Closed by [close]. */
    val session = FitSession(camera, models, settings)
    private val reader = ImageReader.newInstance(camera.width, camera.height, ImageFormat.DEPTH16, 2)
    // close() may come from another thread in the middle of any callback.
    private val lock = Any()
    private var device: CameraDevice? = null
    private var ended = false // closed, or failed
    @Volatile private var down: Direction? = null

    private val gravity = object : SensorEventListener {
        override fun onSensorChanged(event: SensorEvent) {
            down = Direction.ofAndroidGravity(event.values, camera.rotateDeg)
        }
        override fun onAccuracyChanged(sensor: Sensor, accuracy: Int) = Unit
    }

    /** Starts the camera. Frames come until [close]. */
    fun start() {
        sensors.getDefaultSensor(Sensor.TYPE_GRAVITY)?.let {
            sensors.registerListener(gravity, it, SensorManager.SENSOR_DELAY_GAME)
        }
        reader.setOnImageAvailableListener({ feed() }, handler)
        cameras.openCamera(id, opened, handler)
    }

    private fun feed() {
        // With Settings.live a push does not wait, so close() does not wait long.
        val progress = unlessEnded { push() } ?: return
        onProgress(progress)
    }

    private fun push(): Progress? {
        val image = reader.acquireLatestImage() ?: return null
        try {
            val plane = image.planes[0]
            // Three sevenths of full confidence: samples below it are flying pixels at people's outlines.
            session.push(
                DepthFrame(plane.buffer, DepthFormat.DEPTH16, plane.rowStride, image.timestamp, confidenceMin = 3, down = down)
            )
        } finally {
            image.close()
        }
        return session.progress()
    }

    private val opened = object : CameraDevice.StateCallback() {
        override fun onOpened(camera: CameraDevice) {
            val kept = unlessEnded {
                device = camera
                val request = camera.createCaptureRequest(CameraDevice.TEMPLATE_PREVIEW)
                request.addTarget(reader.surface)
                camera.createCaptureSession(listOf(reader.surface), Configured(request), handler)
                camera
            }
            if (kept == null) camera.close() // after close(), or it failed at once
        }
        override fun onDisconnected(camera: CameraDevice) {
            camera.close()
            fail(CameraFailure("another app took the camera, or it is gone"))
        }
        override fun onError(camera: CameraDevice, error: Int) {
            camera.close()
            fail(CameraFailure("the camera failed with CameraDevice.StateCallback error $error"))
        }
    }

    private inner class Configured(private val request: CaptureRequest.Builder) : CameraCaptureSession.StateCallback() {
        override fun onConfigured(capture: CameraCaptureSession) {
            unlessEnded { capture.setRepeatingRequest(request.build(), null, handler) }
        }
        override fun onConfigureFailed(capture: CameraCaptureSession) =
            fail(CameraFailure("the camera does not deliver DEPTH16 of ${camera.width} x ${camera.height}"))
    }

    /** Null after [close] or a failure. An exception is a failure: none may reach the camera's thread, it would end the app. */
    private fun <T> unlessEnded(what: () -> T): T? {
        try {
            return synchronized(lock) { if (ended) null else what() }
        } catch (e: Exception) {
            fail(CameraFailure(e.message ?: e.javaClass.simpleName, e))
            return null
        }
    }

    private fun fail(failure: CameraFailure) {
        val first = synchronized(lock) { !ended.also { ended = true } }
        if (first) onFailure(failure)
    }

    /** A second call does nothing more. */
    override fun close() {
        sensors.unregisterListener(gravity)
        synchronized(lock) {
            ended = true
            device?.close()
            reader.close()
            session.close()
        }
    }

    companion object {
        /** Whether this device has a camera for this class. Needs no permission: ask before anybody undresses. */
        fun isAvailable(context: Context): Boolean {
            val cameras = context.getSystemService(Context.CAMERA_SERVICE) as CameraManager
            return try {
                cameras.cameraIdList.any { hasDepth(cameras.getCameraCharacteristics(it)) }
            } catch (e: Exception) { // the camera service is away
                false
            }
        }

        private fun hasDepth(about: CameraCharacteristics): Boolean =
            about.get(CameraCharacteristics.LENS_FACING) == CameraCharacteristics.LENS_FACING_BACK &&
                about.get(CameraCharacteristics.LENS_INTRINSIC_CALIBRATION) != null &&
                about.get(CameraCharacteristics.SENSOR_INFO_PRE_CORRECTION_ACTIVE_ARRAY_SIZE) != null &&
                about.get(CameraCharacteristics.SCALER_STREAM_CONFIGURATION_MAP)?.getOutputSizes(ImageFormat.DEPTH16)
                    ?.isNotEmpty() == true

        /** The largest picture up to 640 pixels wide, with the lens calibration scaled to it. */
        private fun cameraOf(about: CameraCharacteristics): CameraModel {
            val sizes = about.get(CameraCharacteristics.SCALER_STREAM_CONFIGURATION_MAP)!!.getOutputSizes(ImageFormat.DEPTH16)
            val widest = sizes.sortedByDescending { it.width }
            val size = widest.firstOrNull { it.width <= 640 } ?: widest.last()
            val lens = about.get(CameraCharacteristics.LENS_INTRINSIC_CALIBRATION)
                ?: throw UnsupportedOperationException("the camera does not say its focal length: calibrate it")
            val whole = about.get(CameraCharacteristics.SENSOR_INFO_PRE_CORRECTION_ACTIVE_ARRAY_SIZE)!!
            val scale = size.width.toFloat() / whole.width()
            // Absent when the camera undoes distortion itself. The coefficients apply to rays, not to pixels: they hold at
            // any size.
            val bends = if (Build.VERSION.SDK_INT >= 28) about.get(CameraCharacteristics.LENS_DISTORTION) else null
            // Half a pixel is half a pixel at any scale: the centre of pixel 0 is 0.
            return CameraModel(
                size.width, size.height, lens[0] * scale, lens[1] * scale, (lens[2] + 0.5f) * scale - 0.5f,
                (lens[3] + 0.5f) * scale - 0.5f, about.get(CameraCharacteristics.SENSOR_ORIENTATION) ?: 0,
                if (bends != null) Lens.ofAndroid(bends) else Lens()
            )
        }
    }
}
