/* robot.c - hierarchical motion: a walking robot of nested rtPushMatrix / rtPopMatrix, as with display lists. */
#include "example.h"
#include "shapes.h"

static RTuint box, joint, head, ground;

static RTuint surface(const char *parameter, float r, float g, float b)
{
    const RTuint shader = rtGenNewShader();
    rtParameter3f(rtParameterHandle(parameter), r, g, b);
    return shader;
}

static void makeParts(void)
{
    RTuint paint, rubber, glow, stone;

    rtGenNewShaderClass("phong", NULL);
    paint = surface("diffuse", 0.75f, 0.35f, 0.05f);
    rubber = surface("diffuse", 0.08f, 0.08f, 0.09f);
    stone = surface("diffuse", 0.4f, 0.45f, 0.4f);
    rtGenNewShaderClass("constant", NULL);
    glow = surface("color", 0.3f, 1, 0.9f);

    box = rtGenObjects(4);
    rtNewObject(box, RT_COMPILE);
    rtBindShader(paint);
    solidCube(1);
    rtEndObject();

    joint = box + 1;
    rtNewObject(joint, RT_COMPILE);
    rtBindShader(rubber);
    solidSphere(0.5, 32, 16);
    rtEndObject();

    head = box + 2;
    rtNewObject(head, RT_COMPILE);
    rtBindShader(paint);
    solidCube(0.5);
    rtBindShader(glow);
    rtPushMatrix();
    rtTranslatef(0.12f, 0.06f, 0.25f);
    solidSphere(0.07, 16, 8);
    rtTranslatef(-0.24f, 0, 0);
    solidSphere(0.07, 16, 8);
    rtPopMatrix();
    rtEndObject();

    ground = box + 3;
    rtNewObject(ground, RT_COMPILE | RT_STATIC);
    rtBindShader(stone);
    solidFloor(60);
    rtEndObject();
}

static void part(RTuint object, float x, float y, float z)
{
    rtPushMatrix();
    rtScalef(x, y, z);
    rtInstantiateObject(object);
    rtPopMatrix();
}

/* A limb of two bones that hangs from the origin, bent at `upper` and `lower` degrees. */
static void limb(float length, float width, float upper, float lower)
{
    int bone;
    rtPushMatrix();
    for (bone = 0; bone < 2; bone++) {
        rtRotatef(bone ? lower : upper, 1, 0, 0);
        part(joint, width * 1.3f, width * 1.3f, width * 1.3f);
        rtTranslatef(0, -length / 2, 0);
        part(box, width, length - width, width);
        rtTranslatef(0, -length / 2, 0);
    }
    rtRotatef(-upper - lower, 1, 0, 0);
    rtTranslatef(0, 0, width / 2);
    part(box, width * 1.2f, width * 0.8f, width * 2);
    rtPopMatrix();
}

static void robot(float phase)
{
    int side;
    rtPushMatrix();
    rtTranslatef(0, 1.72f + 0.06f * (float)cos(2 * phase), 0);
    part(box, 0.55f, 0.3f, 0.4f);
    for (side = -1; side <= 1; side += 2) {
        const float swing = (float)sin(phase) * (float)side, lift = (float)cos(phase) * (float)side;
        rtPushMatrix();
        rtTranslatef(0.22f * (float)side, -0.1f, 0);
        limb(0.75f, 0.18f, -32 * swing, lift > 0 ? 45 * lift : 0);
        rtPopMatrix();
    }
    rtRotatef(6 * (float)sin(phase), 0, 1, 0);
    rtTranslatef(0, 0.6f, 0);
    part(box, 0.8f, 0.8f, 0.45f);
    for (side = -1; side <= 1; side += 2) {
        rtPushMatrix();
        rtTranslatef(0.52f * (float)side, 0.28f, 0);
        limb(0.55f, 0.15f, 30 * (float)sin(phase) * (float)side, -35);
        rtPopMatrix();
    }
    rtTranslatef(0, 0.7f, 0);
    rtRotatef(12 * (float)cos(phase), 0, 1, 0);
    rtInstantiateObject(head);
    rtPopMatrix();
}

int main(int argc, char **argv)
{
    Example e;
    RTuint lamp, ambient;
    int frame, i;

    rtInit(&argc, argv);
    e = exampleOptions(argc, argv, 12);
    rtViewport(0, 0, e.width, e.height);
    rtEnable(RT_FRAMEBUFFER_SRGB);
    rtSamplesPerPixel(4);
    rtClearColor(0.5f, 0.6f, 0.7f, 1);
    rtPerspective(35, (RTdouble)e.width / e.height, 0.1, 100);
    rtLookAt(5, 3.5, 8, 0, 1.3, 0, 0, 1, 0);

    makeParts();
    rtGenNewShaderClass("directional", NULL);
    lamp = surface("direction", -0.7f, -1, -0.4f);
    rtGenNewShaderClass("ambient", NULL);
    ambient = surface("color", 0.4f, 0.4f, 0.5f);

    for (frame = 0; frame < e.frames; frame++) {
        const float phase = (float)(2 * PI) * (float)frame / (float)e.frames;
        rtUseLight(ambient);
        rtUseLight(lamp);
        rtInstantiateObject(ground);
        for (i = -1; i <= 1; i++) {
            rtPushMatrix();
            rtTranslatef(2.2f * (float)i, 0, -1.5f * (float)(i * i) + 0.6f * phase);
            robot(phase + 2 * (float)i);
            rtPopMatrix();
        }
        rtRender();
        exampleWrite(&e, "robot", frame);
    }
    return exampleEnd();
}
