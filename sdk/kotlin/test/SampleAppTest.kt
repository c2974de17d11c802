// SPDX-License-Identifier: Apache-2.0
// The steps of the sample app, on stubs of Android's classes, with the golden clip before its camera.
package im2fit.sdk.test

import android.content.Context
import android.hardware.SensorManager
import android.hardware.camera2.CameraManager
import android.media.Image
import android.media.ImageReader
import android.os.Handler
import im2fit.sampleapp.*
import im2fit.sdk.*
import java.nio.ByteBuffer
import java.nio.ByteOrder

/** A frame of a clip as DEPTH16: millimetres below 8.19 m are their own code, with full confidence. */
class ClipImage(private val depth: ShortArray, private val wide: Int, private val number: Int) : Image() {
    override fun getPlanes(): Array<Plane> = arrayOf(object : Plane() {
        override fun getBuffer(): ByteBuffer = ByteBuffer.allocateDirect(2 * depth.size).order(ByteOrder.nativeOrder()).also {
            it.asShortBuffer().put(depth)
        }
        override fun getRowStride() = 2 * wide
    })
    override fun getTimestamp() = number * 1_000_000_000L / 30 + 1
    override fun close() = Unit
}

class Visit(private val models: Models, private val cameras: CameraManager? = FakeCameras()) {
    val all = mutableListOf<Shown>()
    private val context = object : Context() {
        override fun getSystemService(name: String): Any = when (name) {
            CAMERA_SERVICE -> cameras ?: object : CameraManager() {
                override fun getCameraIdList() = arrayOf<String>()
            }
            else -> SensorManager()
        }
    }
    var lacking: String? = null
    val measuring = Measuring(context, { use ->
        lacking?.let { throw java.io.FileNotFoundException(it) }
        use(models)
    }, Handler(), { it() }, { all += it })
    val step get() = measuring.shown.step

    fun begin(turn: Boolean = false): Visit {
        measuring.granted(true)
        measuring.start(turn)
        return this
    }

    fun image(image: Image) {
        ImageReader.latest.next = image
        ImageReader.latest.listener.onImageAvailable(ImageReader.latest)
    }
}

fun sampleAppTests(models: Models, clip: Clip) {
    test("the sample app asks for the camera, measures nobody in an empty room, and deletes") {
        val visit = Visit(models)
        same(visit.step, Step.PERMISSION, "the first step")
        visit.measuring.start(true)
        visit.measuring.granted(false)
        same(visit.step, Step.PERMISSION, "the step without the permission")
        visit.begin()
        same(visit.step, Step.MEASURING, "the step after consent")
        val reader = ImageReader.latest
        visit.image(FakeImage())
        same(visit.measuring.shown.progress!!.framesSeen in 0..1L, true, "a progress")
        visit.measuring.stop()
        same(visit.step, Step.NOT_MEASURED, "the step after stopping")
        expect(visit.measuring.shown.guidance == setOf(Guidance.NO_PERSON)) { "${visit.measuring.shown.guidance}" }
        expect(reader.closed) { "the camera stays on" }
        visit.measuring.delete()
        same(visit.measuring.shown, Shown(Step.READY), "all that is left")
        visit.measuring.close()
    }
    test("the sample app says before anybody undresses that a phone cannot measure") {
        val visit = Visit(models, null)
        same(visit.step, Step.UNSUPPORTED, "the first step")
        visit.begin()
        visit.measuring.delete()
        same(visit.step, Step.UNSUPPORTED, "the step after all buttons")
    }
    test("the sample app measures and keeps the person's numbers alone") {
        val visit = Visit(models, FakeCameras(4 * clip.camera.fx)).begin()
        val reader = ImageReader.latest
        var masks = 0
        for (round in 0 until 400) {
            if (visit.step != Step.MEASURING) break
            visit.image(ClipImage(clip.depth[round % clip.depth.size], clip.camera.width, round))
            if (visit.measuring.shown.mask?.pixels?.any { it != 0.toByte() } == true) ++masks
            Thread.sleep(20) // the session is live: what comes too fast is dropped
        }
        same(visit.step, Step.RESULT, "the step of a person who stood still, after ${visit.measuring.shown}")
        expect(masks > 0) { "no mask with a person" }
        val stature = visit.measuring.shown.person!![Measurement.STATURE].value
        expect(stature in 1400f..2100f) { "$stature mm" }
        expect(reader.closed) { "the camera stays on" }
        same(visit.all.count { it.step == Step.RESULT }, 1, "results")
        visit.measuring.delete()
        same(visit.measuring.shown, Shown(Step.READY), "all that is left")
    }
    test("the sample app reports a failure and begins again") {
        val cameras = FakeCameras()
        val visit = Visit(models, cameras).begin()
        val device = FakeDevice()
        cameras.opened!!.onOpened(device)
        cameras.opened!!.onError(device, 3)
        same(visit.step, Step.FAILED, "the step")
        expect("error 3" in visit.measuring.shown.failure!!) { "${visit.measuring.shown}" }
        // The golden clip's index has no shapes, which a turn needs.
        visit.measuring.start(true)
        same(visit.step, Step.FAILED, "the step with models that measure no turn")
        expect("turn" in visit.measuring.shown.failure!!) { "${visit.measuring.shown}" }
        visit.measuring.start(false)
        same(visit.step, Step.MEASURING, "the step of the third try")
        visit.measuring.leave()
        same(visit.step, Step.READY, "the step after the app has left the screen")
        visit.lacking = "im2fit-models.i2p"
        visit.measuring.start(false)
        same(visit.measuring.shown, Shown(Step.FAILED, failure = "im2fit-models.i2p"), "what an APK without models shows")
    }
    test("the sample app's words and pictures") {
        val progress = Progress(State.TURNING, emptySet(), emptySet(), 9, 9, 0, 1, 0, emptyList(), -90f, 30)
        same(share(progress), 0.25f, "the share of a quarter turn")
        same(share(progress.copy(state = State.TRACKING, framesUsed = 15)), 0.5f, "the share of half of the frames")
        same(share(null), 0f, "the share of nothing")
        same(shownNumber(Measurement.WAIST_GIRTH, 846f), "85", "cm")
        same(shownNumber(Measurement.WEIGHT, 71.6f) + shownUnit(Measurement.WEIGHT), "72kg", "kg")
        val colours = colours(Mask(2, 1, byteArrayOf(0, -1), 1, 0, 0))
        expect(colours[0] != colours[1] && colours.all { it ushr 24 == 255 }) { colours.joinToString() }
    }
}
