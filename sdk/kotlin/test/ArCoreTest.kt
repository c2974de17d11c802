// SPDX-License-Identifier: Apache-2.0
// The sample for ARCore on stubs of its classes: what it pushes measures as the same pictures without ARCore.
package im2fit.sdk.test

import android.content.res.AssetFileDescriptor
import android.content.res.AssetManager
import android.media.Image
import com.google.ar.core.Camera
import com.google.ar.core.CameraIntrinsics
import com.google.ar.core.Config
import com.google.ar.core.Frame
import com.google.ar.core.Pose
import com.google.ar.core.Session
import com.google.ar.core.TrackingState
import im2fit.sample.ArCoreFeeder
import im2fit.sample.ofAssets
import im2fit.sdk.*
import java.nio.ByteBuffer
import java.nio.ByteOrder

private class Picture(private val wide: Int, private val high: Int, private val ns: Long, bytes: ByteArray) : Image() {
    // Rows are longer than their samples, as a camera's are.
    private val row = bytes.size / high + 64
    private val held = ByteBuffer.allocateDirect(row * high).order(ByteOrder.nativeOrder())
    var closed = false

    init {
        for (y in 0 until high) {
            held.position(y * row)
            held.put(bytes, y * (row - 64), row - 64)
        }
        held.position(0)
    }

    override fun getPlanes(): Array<Plane> = arrayOf(object : Plane() {
        override fun getBuffer() = held
        override fun getRowStride() = row
    })
    override fun getWidth() = wide
    override fun getHeight() = high
    override fun getTimestamp() = ns
    override fun close() {
        closed = true
    }
}

/** A frame of a phone at [metres] with the depth of another moment, or none. */
private class ArFrame(
    private val model: CameraModel, private val ns: Long, private val metres: Float, private val depth: Pair<Picture, Picture>?,
    private val tracking: TrackingState = TrackingState.TRACKING
) : Frame() {
    override fun getTimestamp() = ns
    override fun acquireRawDepthImage16Bits(): Image = depth?.first ?: super.acquireRawDepthImage16Bits()
    override fun acquireRawDepthConfidenceImage(): Image = depth?.second ?: super.acquireRawDepthConfidenceImage()
    override fun getCamera() = object : Camera() {
        override fun getPose() = Pose(floatArrayOf(metres, 0f, 0f), floatArrayOf(0f, 0f, 0f, 1f))
        override fun getTrackingState() = tracking
        // Of a texture twice as large.
        override fun getTextureIntrinsics() = object : CameraIntrinsics() {
            override fun getFocalLength() = floatArrayOf(2 * model.fx, 2 * model.fy)
            override fun getPrincipalPoint() = floatArrayOf(2 * model.cx + 0.5f, 2 * model.cy + 0.5f)
            override fun getImageDimensions() = intArrayOf(2 * model.width, 2 * model.height)
        }
    }
}

fun arCoreTests(models: Models, clip: Clip) {
    val model = clip.camera
    // Where the clip has no depth, ARCore has wrong depth that it does not trust.
    fun pictures(number: Int): Pair<Picture, Picture> {
        val depth = ByteBuffer.allocate(2 * clip.depth[number].size).order(ByteOrder.nativeOrder())
        val sure = ByteArray(clip.depth[number].size)
        clip.depth[number].forEachIndexed { i, mm ->
            depth.putShort(2 * i, if (mm == 0.toShort()) 900 else mm)
            sure[i] = (if (mm == 0.toShort()) 127 else 128).toByte()
        }
        val ns = 1 + clip.timeNs(number)
        return Pair(Picture(model.width, model.height, ns, depth.array()), Picture(model.width, model.height, ns, sure))
    }

    test("ARCore's raw depth measures as the same depth without ARCore") {
        val expected = FitSession(model, models, quick).use { it.measure(clip.frames()) }
        expect(expected is Outcome.Measured) { "$expected" }
        val feeder = ArCoreFeeder(models, quick, model.rotateDeg)
        var states = 0
        for (number in clip.depth.indices) {
            val ns = 1 + clip.timeNs(number)
            val (depth, sure) = pictures(number)
            // The depth of one frame comes with the next, when the phone is elsewhere.
            same(feeder.feed(ArFrame(model, ns, 0f, null)), null, "a frame without depth")
            if (feeder.feed(ArFrame(model, ns + 20_000_000, 0.5f, Pair(depth, sure))) != null) states++
            expect(depth.closed && sure.closed) { "a picture was kept" }
            same(feeder.feed(ArFrame(model, ns + 25_000_000, 0.5f, Pair(depth, sure))), null, "depth that was seen already")
        }
        same(states, clip.depth.size, "frames pushed")
        same(feeder.session!!.finish(), expected, "the outcome")
        feeder.close()
        feeder.close()
    }
    test("ARCore without a place, or with depth of long ago, feeds nothing") {
        ArCoreFeeder(models, quick, model.rotateDeg).use { feeder ->
            val (depth, sure) = pictures(0)
            same(feeder.feed(ArFrame(model, 1, 0f, Pair(depth, sure), TrackingState.PAUSED)), null, "not tracking")
            same(feeder.feed(ArFrame(model, 60_000_000, 0f, Pair(depth, sure))), null, "59 ms late")
            same(feeder.session, null, "the session")
            expect(depth.closed && sure.closed) { "a picture was kept" }
        }
        same(ArCoreFeeder.isAvailable(Session()), false, "raw depth of the stub")
        same(ArCoreFeeder.isAvailable(object : Session() {
            override fun isDepthModeSupported(mode: Config.DepthMode) = mode == Config.DepthMode.RAW_DEPTH_ONLY
        }), true, "raw depth")
    }
    test("models of the app's assets are closed once they are open") {
        var closed = 0
        val assets = object : AssetManager() {
            override fun openFd(name: String) = object : AssetFileDescriptor() {
                override fun getParcelFileDescriptor() = object : android.os.ParcelFileDescriptor() {
                    override fun getFd() = 7
                }
                override fun getStartOffset() = 1000L
                override fun getLength() = 2000L
                override fun close() {
                    closed++
                }
            }
        }
        Models.ofAssets(assets, "im2fit-models.i2p") {
            same(closed, 0, "closed while it opens")
            for (file in listOf(it.tracker, it.index, it.body)) same(file, ModelFile.Descriptor(7, 1000, 2000) as ModelFile, "the pack")
        }
        same(closed, 1, "closed")
    }
}
