// SPDX-License-Identifier: Apache-2.0
// A sample: a Camera2 camera that delivers DEPTH16 feeds a session. Copy it into an app. The tests compile it with stubs of
// Android's classes. It has not run on a phone.
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
import android.media.ImageReader
import android.os.Build
import android.os.Handler
import im2fit.sdk.Camera
import im2fit.sdk.DepthFormat
import im2fit.sdk.Direction
import im2fit.sdk.Frame
import im2fit.sdk.Lens
import im2fit.sdk.Models
import im2fit.sdk.Progress
import im2fit.sdk.Session
import im2fit.sdk.Settings

/**
 * Opens the first back camera with DEPTH16 and calls [onProgress] after each frame, on [handler]'s thread. The app holds the
 * CAMERA permission. Call [close] once, from any thread.
 */
class DepthFeeder(context: Context, models: Models, private val handler: Handler, private val onProgress: (Progress) -> Unit) :
    AutoCloseable {
    private val cameras = context.getSystemService(Context.CAMERA_SERVICE) as CameraManager
    private val sensors = context.getSystemService(Context.SENSOR_SERVICE) as SensorManager
    private val id = cameras.cameraIdList.firstOrNull { hasDepth(cameras.getCameraCharacteristics(it)) }
        ?: throw UnsupportedOperationException("no back camera of this device delivers DEPTH16")
    private val camera = cameraOf(cameras.getCameraCharacteristics(id))
    private val session = Session(camera, models, Settings(live = true))
    private val reader = ImageReader.newInstance(camera.width, camera.height, ImageFormat.DEPTH16, 2)
    private var device: CameraDevice? = null
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
        val image = reader.acquireLatestImage() ?: return
        try {
            val plane = image.planes[0]
            // Three sevenths of full confidence: samples below it are flying pixels at people's outlines.
            session.push(Frame(plane.buffer, DepthFormat.DEPTH16, plane.rowStride, image.timestamp, confidenceMin = 3, down = down))
        } finally {
            image.close()
        }
        onProgress(session.progress())
    }

    private val opened = object : CameraDevice.StateCallback() {
        override fun onOpened(camera: CameraDevice) {
            device = camera
            val request = camera.createCaptureRequest(CameraDevice.TEMPLATE_PREVIEW)
            request.addTarget(reader.surface)
            camera.createCaptureSession(listOf(reader.surface), object : CameraCaptureSession.StateCallback() {
                override fun onConfigured(capture: CameraCaptureSession) {
                    capture.setRepeatingRequest(request.build(), null, handler)
                }
                override fun onConfigureFailed(capture: CameraCaptureSession) = camera.close()
            }, handler)
        }
        override fun onDisconnected(camera: CameraDevice) = camera.close()
        override fun onError(camera: CameraDevice, error: Int) = camera.close()
    }

    override fun close() {
        sensors.unregisterListener(gravity)
        device?.close()
        reader.close()
        session.close()
    }

    private companion object {
        fun hasDepth(about: CameraCharacteristics): Boolean =
            about.get(CameraCharacteristics.LENS_FACING) == CameraCharacteristics.LENS_FACING_BACK &&
                about.get(CameraCharacteristics.SCALER_STREAM_CONFIGURATION_MAP)?.getOutputSizes(ImageFormat.DEPTH16)
                    ?.isNotEmpty() == true

        /** The largest picture up to 640 pixels wide, with the lens calibration scaled to it. */
        fun cameraOf(about: CameraCharacteristics): Camera {
            val sizes = about.get(CameraCharacteristics.SCALER_STREAM_CONFIGURATION_MAP)!!.getOutputSizes(ImageFormat.DEPTH16)
            val size = sizes.filter { it.width <= 640 }.maxBy { it.width } ?: sizes.minBy { it.width }!!
            val lens = about.get(CameraCharacteristics.LENS_INTRINSIC_CALIBRATION)
                ?: throw UnsupportedOperationException("the camera does not say its focal length: calibrate it")
            val whole = about.get(CameraCharacteristics.SENSOR_INFO_PRE_CORRECTION_ACTIVE_ARRAY_SIZE)!!
            val scale = size.width.toFloat() / whole.width()
            // Absent when the camera undoes distortion itself. The coefficients apply to rays, not to pixels: they hold at
            // any size.
            val bends = if (Build.VERSION.SDK_INT >= 28) about.get(CameraCharacteristics.LENS_DISTORTION) else null
            // Half a pixel is half a pixel at any scale: the centre of pixel 0 is 0.
            return Camera(
                size.width, size.height, lens[0] * scale, lens[1] * scale, (lens[2] + 0.5f) * scale - 0.5f,
                (lens[3] + 0.5f) * scale - 0.5f, about.get(CameraCharacteristics.SENSOR_ORIENTATION) ?: 0,
                if (bends != null) Lens.ofAndroid(bends) else Lens()
            )
        }
    }
}
