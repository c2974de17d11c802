// SPDX-License-Identifier: Apache-2.0
// The sample's life on stubs of Android's classes: what a camera may do at any moment, and an app that closes meanwhile.
package im2fit.sdk.test

import android.content.Context
import android.graphics.Rect
import android.hardware.SensorManager
import android.hardware.camera2.CameraCaptureSession
import android.hardware.camera2.CameraCharacteristics
import android.hardware.camera2.CameraDevice
import android.hardware.camera2.CameraManager
import android.hardware.camera2.CaptureRequest
import android.hardware.camera2.params.StreamConfigurationMap
import android.media.Image
import android.media.ImageReader
import android.os.Handler
import android.util.Size
import android.view.Surface
import im2fit.sample.CameraFailure
import im2fit.sample.DepthFeeder
import im2fit.sdk.*
import java.nio.ByteBuffer
import kotlin.concurrent.thread

const val WIDTH = 320
const val HEIGHT = 240

class FakeCapture : CameraCaptureSession() {
    var repeating = 0
    override fun setRepeatingRequest(request: CaptureRequest?, listener: CaptureCallback?, handler: Handler?): Int = ++repeating
}

class FakeDevice : CameraDevice() {
    var closed = false
    var configured: CameraCaptureSession.StateCallback? = null
    override fun createCaptureRequest(template: Int): CaptureRequest.Builder {
        check(!closed) { "the device is closed" }
        return CaptureRequest.Builder()
    }
    override fun createCaptureSession(outputs: List<Surface>, callback: CameraCaptureSession.StateCallback, handler: Handler?) {
        configured = callback
    }
    override fun close() {
        closed = true
    }
}

/** A plane with [bytes] bytes of an empty room. */
class FakeImage(private val bytes: Int = 2 * WIDTH * HEIGHT, private val onPlanes: () -> Unit = {}) : Image() {
    var closed = false
    override fun getPlanes(): Array<Plane> {
        onPlanes()
        return arrayOf(object : Plane() {
            override fun getBuffer(): ByteBuffer = ByteBuffer.allocateDirect(bytes)
            override fun getRowStride() = 2 * WIDTH
        })
    }
    override fun getTimestamp() = 1L
    override fun close() {
        closed = true
    }
}

/** @param focal of a picture four times as large, px */
class FakeCameras(private val focal: Float = 1000f) : CameraManager() {
    var opened: CameraDevice.StateCallback? = null
    override fun getCameraIdList() = arrayOf("0")
    override fun getCameraCharacteristics(id: String) = object : CameraCharacteristics() {
        @Suppress("UNCHECKED_CAST")
        override fun <T> get(key: Key<T>): T = value(key) as T
        private fun value(key: Key<*>): Any? = when (key) {
            LENS_FACING -> LENS_FACING_BACK
            SCALER_STREAM_CONFIGURATION_MAP -> object : StreamConfigurationMap() {
                override fun getOutputSizes(format: Int): Array<Size> = arrayOf(object : Size() {
                    override fun getWidth() = WIDTH
                    override fun getHeight() = HEIGHT
                })
            }
            LENS_INTRINSIC_CALIBRATION -> floatArrayOf(focal, focal, 639.5f, 479.5f, 0f)
            SENSOR_INFO_PRE_CORRECTION_ACTIVE_ARRAY_SIZE -> object : Rect() {
                override fun width() = 4 * WIDTH
            }
            SENSOR_ORIENTATION -> 90
            else -> null
        }
    }
    override fun openCamera(id: String, callback: CameraDevice.StateCallback, handler: Handler?) {
        opened = callback
    }
}

class Feeding(models: Models) {
    val cameras = FakeCameras()
    val failures = mutableListOf<CameraFailure>()
    val states = mutableListOf<Progress>()
    private val context = object : Context() {
        override fun getSystemService(name: String): Any = if (name == CAMERA_SERVICE) cameras else SensorManager()
    }
    val feeder = DepthFeeder(context, models, Handler(), quick.copy(live = true), { failures += it }) { states += it }
    val reader: ImageReader = ImageReader.latest
    val device = FakeDevice()
    val capture = FakeCapture()

    init {
        feeder.start()
    }

    fun open() = cameras.opened!!.onOpened(device)
    fun configure() = device.configured!!.onConfigured(capture)
    fun image(image: FakeImage) {
        reader.next = image
        reader.listener.onImageAvailable(reader)
    }
}

fun feederTests(models: Models) {
    test("a camera feeds the session") {
        val feeding = Feeding(models)
        feeding.open()
        feeding.configure()
        same(feeding.capture.repeating, 1, "requests")
        val image = FakeImage()
        feeding.image(image)
        same(feeding.states.size, 1, "states after a frame")
        expect(image.closed) { "the image was kept" }
        feeding.feeder.close()
        expect(feeding.device.closed && feeding.reader.closed) { "camera or reader stay open" }
        same(feeding.failures.size, 0, "failures")
    }
    test("closing in the middle of a frame throws nothing on the camera's thread") {
        val feeding = Feeding(models)
        feeding.open()
        var closing: Thread? = null
        // From another thread, between the image and the push, as when the person leaves the screen.
        val image = FakeImage {
            closing = thread { feeding.feeder.close() }
            closing!!.join(200)
        }
        feeding.image(image)
        closing!!.join()
        expect(image.closed && feeding.device.closed && feeding.reader.closed) { "not all is closed" }
        same(feeding.failures.size, 0, "failures")
        val states = feeding.states.size
        feeding.image(FakeImage())
        same(feeding.states.size, states, "states after close")
        feeding.feeder.close()
    }
    test("a camera that opens after close is closed") {
        val feeding = Feeding(models)
        feeding.feeder.close()
        feeding.open()
        expect(feeding.device.closed) { "the camera stays open" }
        same(feeding.device.configured, null, "the capture session")
        // Closed between opening and configuring.
        val between = Feeding(models)
        between.open()
        between.feeder.close()
        between.configure()
        same(between.capture.repeating, 0, "requests to a closed camera")
        same(feeding.failures.size + between.failures.size, 0, "failures")
    }
    test("the app is told once when the camera fails") {
        val lost = Feeding(models)
        lost.open()
        lost.cameras.opened!!.onDisconnected(lost.device)
        lost.cameras.opened!!.onError(lost.device, 4)
        same(lost.failures.size, 1, "failures of a camera that went away")
        expect(lost.device.closed) { "the camera stays open" }
        lost.image(FakeImage())
        same(lost.states.size, 0, "states after the failure")

        val broken = Feeding(models)
        broken.open()
        broken.cameras.opened!!.onError(broken.device, 4)
        expect("error 4" in broken.failures.single().message!!) { "${broken.failures}" }

        val refused = Feeding(models)
        refused.open()
        refused.device.configured!!.onConfigureFailed(refused.capture)
        expect("320 x 240" in refused.failures.single().message!!) { "${refused.failures}" }

        val late = Feeding(models) // the device is gone when it is asked for a request
        late.device.close()
        late.open()
        expect("the device is closed" in late.failures.single().message!!) { "${late.failures}" }

        val short = Feeding(models)
        short.open()
        val image = FakeImage(bytes = 100)
        short.image(image)
        expect("pixels has 100 bytes" in short.failures.single().message!! && image.closed) { "${short.failures}" }

        val quiet = Feeding(models)
        quiet.open()
        quiet.feeder.close()
        quiet.cameras.opened!!.onDisconnected(quiet.device) // Android reports it after close, too
        same(quiet.failures.size, 0, "failures after close")
        for (feeding in listOf(lost, broken, refused, late, short)) feeding.feeder.close()
    }
}
